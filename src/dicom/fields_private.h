/* Attributes of one frame, looked for where they may be: in its own functional groups, in the shared ones, in the data
 * set (PS3.3 C.7.6.16). Needs DCMTK, so it is apart from dicom_private.h. */
#ifndef VITRINE_DICOM_FIELDS_PRIVATE_H
#define VITRINE_DICOM_FIELDS_PRIVATE_H

#include "dcmtk/dcmdata/dcitem.h"

#include "dicom_private.h"

namespace vitdicom {

class Fields {
    std::vector<DcmItem *> places;

  public:
    explicit Fields(DcmItem &item) : places{&item} {}
    explicit Fields(std::vector<DcmItem *> where) : places(std::move(where)) {}
    /* The first place that has the attribute with a value; NULL if none. */
    DcmElement *find(const DcmTagKey &key) const;
    std::string text(const DcmTagKey &key) const;
    int integer(const DcmTagKey &key, int absent) const;
    bool word(const DcmTagKey &key, unsigned &out) const;
    /* All of `count` finite numbers, or none. */
    bool numbers(const DcmTagKey &key, double *out, unsigned count) const;
    /* There is a value, but not one number. */
    bool is_damaged(const DcmTagKey &key) const;
    double length(const DcmTagKey &key) const;
    bool has_items(const DcmTagKey &key) const;
};

/* How cells are stored. `reject`: this can be no slice; slice.refused: a slice we cannot read. */
bool fields_format(const Fields &fields, Slice &slice, std::string &reject);
/* Everything else of a frame; slice.format must be there, as it says how padding is read. */
void fields_frame(const Fields &fields, Slice &slice);

/* frames.cc: the places of every frame of a multi-frame data set, in order; empty when it has no functional groups. */
std::vector<std::vector<DcmItem *>> frames_places(DcmItem &data);

/* offsets.cc: the places of attributes where there are no functional groups. */
std::vector<DcmItem *> frames_whole(DcmItem &data);
/* Moves the frames of such a data set, which all lie where the first does, to their places, and names their phases. Not
 * empty: why they have none. */
std::string frames_offsets(const Fields &fields, std::vector<Slice> &slices);

/* table.cc: what ModalityLUTSequence says of the values, if it is there; slice.lut, or slice.refused. */
void fields_table(const Fields &fields, Slice &slice);

} // namespace vitdicom

#endif
