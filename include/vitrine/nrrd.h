/* nrrd: the Nearly Raw Raster Data format in and out, for volumes and float images. Raw and gzip encodings, attached
 * (.nrrd) and detached (.nhdr) headers, all integer and float types, both endians, space directions.
 * Format: teem, "Definition of NRRD File Format" (NRRD0001 to NRRD0005). zlib stays in this folder. */
#ifndef VITRINE_NRRD_H
#define VITRINE_NRRD_H

#include "vitrine/core.h"

enum vit_nrrd_type {
    VIT_NRRD_UNKNOWN = 0,
    VIT_NRRD_I8,
    VIT_NRRD_U8,
    VIT_NRRD_I16,
    VIT_NRRD_U16,
    VIT_NRRD_I32,
    VIT_NRRD_U32,
    VIT_NRRD_I64,
    VIT_NRRD_U64,
    VIT_NRRD_F32,
    VIT_NRRD_F64,
    VIT_NRRD_TYPE_COUNT
};
size_t vit_nrrd_type_bytes(enum vit_nrrd_type type); /* 0 for unknown */

/* A header: axis 0 is the fastest. Plain value. */
struct vit_nrrd_header {
    enum vit_nrrd_type type;
    int dimension; /* [1, 4] */
    size_t sizes[4];
    int domain_axis; /* the first domain axis: 0, or 1 when axis 0 is a list of channels */
    bool gzip;
    bool big_endian;
    /* Index → LPS mm of the three domain axes (axes 0–2, or 1–3 when axis 0 is a list of channels); sample centres.
     * Only filled when has_geometry; "right-anterior-superior" and the other spaces are turned into LPS. A file with
     * `spacings` only gives a diagonal matrix and has_orientation = false, and so does one whose space names no
     * patient. Axes that the file does not have are 1 mm along the normal of those that it has. */
    bool has_geometry, has_orientation;
    struct vit_mat4 lps_mm_from_index;
    double slope,
        intercept; /* value = slope·sample + intercept; 1, 0 unless key/value `vitrine slope/intercept` say so */
    bool not_hu;   /* key/value `vitrine is_hu:=false`: values are no Hounsfield units */
};

/* An opened file: header parsed and checked (sizes consistent with the file, no absurd products). */
struct vit_nrrd_reader;
struct vit_nrrd_reader *vit_nrrd_reader_create(const char *path, const struct vit_log *log);
const struct vit_nrrd_header *vit_nrrd_reader_header(const struct vit_nrrd_reader *reader);
/* Product of sizes (checked at create). */
size_t vit_nrrd_reader_samples(const struct vit_nrrd_reader *reader);
/* Reads the next `count` samples (host byte order, the header's type) into `out`: lets a caller stream. */
VIT_NODISCARD bool vit_nrrd_reader_read(struct vit_nrrd_reader *reader, void *out, size_t count);
void vit_nrrd_reader_destroy(struct vit_nrrd_reader **reader);

/* Writes header and data (`samples`: host byte order; the file's is header->big_endian; same bytes for the same input).
 * Reading it back gives bit-identical samples and geometry, except for a matrix that is not given in LPS. .nhdr writes
 * a detached NAME.raw or NAME.raw.gz beside it. Appears whole or not at all. */
VIT_NODISCARD bool vit_nrrd_write(const char *path, const struct vit_nrrd_header *header, const void *samples,
                                  const struct vit_log *log);

#endif
