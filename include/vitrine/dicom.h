/* dicom: folders of DICOM files → stacks → samples, and volumes → CT series. The only C++ of the project, behind this
 * plain C interface: no exception and no C++ type crosses it. */
#ifndef VITRINE_DICOM_H
#define VITRINE_DICOM_H

#include "vitrine/volume.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Warnings: X(enumerator, stable identifier, what it means). A warning of a stack is "identifier: details". */
#define VIT_DICOM_WARNINGS(X)                                                                                          \
    X(BITS_MENDED, "bits-mended", "the codestream holds another number of bits than BitsStored says; it is believed")  \
    X(DUPLICATE_FILES, "duplicate-files", "identical copies of slices were left out")                                  \
    X(FRAMES_ASSUMED, "frames-assumed", "frames placed by a distance from the first alone, along the slice normal")    \
    X(GANTRY_TILT, "gantry-tilt", "slice positions run off the slice normal: drawn as a sheared volume")               \
    X(LOCALIZER, "localizer", "a scout image, not a cross section; never taken by default beside a CT")                \
    X(LOSSY, "lossy", "pixels were compressed with loss")                                                              \
    X(MODALITY_LUT, "modality-lut", "values go through the file's table (ModalityLUTSequence), not a slope")           \
    X(MONOCHROME1, "monochrome1", "MONOCHROME1: mirrored so that bright means more, except where values are HU")       \
    X(NOT_HU, "not-hu", "values of this CT are not marked as Hounsfield units")                                        \
    X(ORIENTATION_MISSING, "orientation-missing", "a single slice without ImageOrientationPatient; taken as axial")    \
    X(PHASES_BY_TIME, "phases-by-time", "slices at the same places were told apart by time alone")                     \
    X(POSITION_MISSING, "position-missing", "a single slice without ImagePositionPatient; placed at the origin")       \
    X(RESCALE_MISSING, "rescale-missing", "no RescaleSlope and RescaleIntercept; stored values are taken as HU")       \
    X(RESCALE_REQUANTISED, "rescale-requantised", "rescale values of the slices have no common step; rounded")         \
    X(RESCALE_VARIES, "rescale-varies", "slices have different rescale values; brought exactly to one")                \
    X(SIGN_MENDED, "sign-mended", "the codestream's sign is not what PixelRepresentation says")                        \
    X(SLICE_GAPS, "slice-gaps", "slices are thinner than the distance between them; what lies between is unknown")     \
    X(SLICES_MISSING, "slices-missing", "missing slices were interpolated, few enough; the text says which")           \
    X(SPACING_FROM_THICKNESS, "spacing-from-thickness", "a single slice; its extent is taken from SliceThickness")     \
    X(SPACING_UNEVEN, "spacing-uneven", "resampled onto even steps; the text says where data was made up")             \
    X(SPACING_UNKNOWN, "spacing-unknown", "a single slice without SliceThickness; taken as 1 mm")                      \
    X(TILT_TAG, "tilt-tag", "GantryDetectorTilt and the slice positions disagree; the positions are believed")         \
    X(VALUES_QUANTISED, "values-quantised", "pixels of 32 or 64 bits were rounded to even steps")

/* The table of the above; id NULL ends. */
struct vit_dicom_warning {
    const char *id, *help;
};
extern const struct vit_dicom_warning vit_dicom_warnings[];

/* One stack: slices of one series with the same orientation, matrix and acquisition, ordered along the slice normal. */
struct vit_dicom_stack {
    const char *series_uid;      /* never shown unless asked for: it may identify */
    int series_number;           /* -1 when absent */
    int acquisition_number;      /* -1 when absent */
    const char *modality;        /* "CT", … */
    const char *plane;           /* "axial", "coronal", "sagittal", "oblique" */
    const char *transfer_syntax; /* readable name of the first file's */
    const char *label;           /* what tells it from others of its series ("acquisition 2"), or "" */
    size_t slices;               /* images that it is made of; info.n[2] may be more */
    size_t interpolated;         /* slices of the volume that no image holds (spacing-uneven, slices-missing) */
    struct vit_volume_info info; /* what vit_dicom_stack_read will deliver */
    double slice_thickness_mm;   /* the tag, for information only; 0 when absent */
    bool readable;               /* false: refused says why, in one line */
    const char *refused;
    const char *const *warnings; /* "stable-id: text", NULL ends */
};

/* What was found in a set of paths. */
struct vit_dicom_scan;
/* Paths are files, folders (walked recursively; FIFOs and devices are skipped, symlink loops harmless), DICOMDIRs, or
 * zips, whose members are read in memory and named by number. Headers are read in parallel. NULL (logged) when a path
 * cannot be read or nothing in them is DICOM. */
struct vit_dicom_scan *vit_dicom_scan_create(const char *const *paths, size_t path_count, const struct vit_log *log,
                                             const struct vit_progress *progress);
size_t vit_dicom_scan_stack_count(const struct vit_dicom_scan *scan);
const struct vit_dicom_stack *vit_dicom_scan_stack(const struct vit_dicom_scan *scan, size_t index);
/* Files that belong to no stack (no pixels, not an image, unreadable, …): count and one-line reasons ("path: reason").
 */
size_t vit_dicom_scan_rejected_count(const struct vit_dicom_scan *scan);
const char *vit_dicom_scan_rejected(const struct vit_dicom_scan *scan, size_t index);
/* By "N" (the number `info` shows, from 1) or series UID; NULL chooses: the largest CT axial stack, else the largest
 * CT, else the largest readable. Returns the index, or -1 (logged, with what there is). */
ptrdiff_t vit_dicom_scan_choose(const struct vit_dicom_scan *scan, const char *series, const struct vit_log *log);
/* Decodes the stack over all cores into `samples` (vit_volume_info_bytes(&stack->info) bytes, caller's). `sink` (NULL:
 * nobody) hears of every slice as it is decoded, but for those of stacks that are put onto other steps. False: logged.
 */
VIT_NODISCARD bool vit_dicom_stack_read(const struct vit_dicom_scan *scan, size_t index, void *samples, size_t bytes,
                                        const struct vit_slice_sink *sink, const struct vit_log *log,
                                        const struct vit_progress *progress);
void vit_dicom_scan_destroy(struct vit_dicom_scan **scan);

/* True if the path is a folder, or a file that starts like DICOM (preamble, or a plausible first element) or
 * a zip. */
bool vit_dicom_probe(const char *path);

/* Writes a CT Image Storage series (one file a slice, IM0001.dcm …) into `folder`, which is made, and must be empty or
 * absent. Passes dciodvfy; reading it back gives the same HU and geometry. Left-handed matrices are written with the
 * slice order that makes them right-handed patient space (same picture). UIDs are derived from the content, so the same
 * volume gives the same files. The folder appears whole or not at all. */
VIT_NODISCARD bool vit_dicom_write(const struct vit_volume *volume, const char *folder, const struct vit_log *log,
                                   const struct vit_progress *progress);

#ifdef __cplusplus
}
#endif
#endif
