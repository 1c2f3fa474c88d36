/* Functional groups of multi-frame images (PS3.3 C.7.6.16): for every frame the items in which its attributes may be,
 * its own first. The macros are not told apart: none of the attributes that we read is in two of them with two
 * meanings, and Legacy Converted images keep theirs in macros of unassigned attributes. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcsequen.h"

#include "fields_private.h"

namespace vitdicom {

namespace {

/* Items of other images: their attributes are not this frame's. */
bool is_foreign(const DcmTagKey &key)
{
    return key == DCM_ReferencedImageSequence || key == DCM_DerivationImageSequence || (key.getGroup() & 1) != 0;
}

void add_macros(DcmItem &groups, std::vector<DcmItem *> &places)
{
    for (DcmObject *object = groups.nextInContainer(nullptr); object; object = groups.nextInContainer(object)) {
        auto *sequence = dynamic_cast<DcmSequenceOfItems *>(object);
        if (sequence && sequence->card() > 0 && !is_foreign(object->getTag()))
            places.push_back(sequence->getItem(0));
    }
}

DcmSequenceOfItems *sequence_of(DcmItem &data, const DcmTagKey &key)
{
    DcmElement *element = nullptr;
    return data.findAndGetElement(key, element).good() ? dynamic_cast<DcmSequenceOfItems *>(element) : nullptr;
}

} // namespace

std::vector<std::vector<DcmItem *>> frames_places(DcmItem &data)
{
    std::vector<std::vector<DcmItem *>> frames;
    std::vector<DcmItem *> shared;
    DcmSequenceOfItems *own = sequence_of(data, DCM_PerFrameFunctionalGroupsSequence);
    DcmSequenceOfItems *common = sequence_of(data, DCM_SharedFunctionalGroupsSequence);
    if (common && common->card() > 0)
        add_macros(*common->getItem(0), shared);
    shared.push_back(&data);
    for (DcmObject *object = own ? own->nextInContainer(nullptr) : nullptr; object;
         object = own->nextInContainer(object)) {
        auto *item = dynamic_cast<DcmItem *>(object);
        if (!item)
            continue;
        frames.emplace_back();
        add_macros(*item, frames.back());
        frames.back().insert(frames.back().end(), shared.begin(), shared.end());
    }
    if (frames.empty() && shared.size() > 1)
        frames.push_back(shared);
    return frames;
}

} // namespace vitdicom
