/* Where the frames of an image without functional groups lie: dose grids (PS3.3 C.8.8.3.2), nuclear medicine (C.8.4.8,
 * C.8.4.11, C.8.4.15), multi-frame secondary captures (C.8.6.3) and the CT of older writers, which give the first
 * frame's place and a distance. FrameIncrementPointer (C.7.6.6) says what changes from frame to frame; whatever is not
 * a place or a phase (time, angle, energy of a projection) is refused by its name. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcelem.h"
#include "dcmtk/dcmdata/dcsequen.h"
#include "dcmtk/dcmdata/dcvrat.h"

#include "fields_private.h"

#include <cmath>

namespace vitdicom {

namespace {

/* What an attribute named by FrameIncrementPointer tells of a frame: its place, or which stack or phase it is of. */
enum class Axis { place, stack, time };
const struct {
    DcmTagKey key;
    Axis axis;
} axes[] = {
    {DCM_GridFrameOffsetVector, Axis::place},
    {DCM_SliceLocationVector, Axis::place},
    {DCM_SliceVector, Axis::place},
    {DCM_SpacingBetweenSlices, Axis::place},
    {DCM_SliceLocation, Axis::place},
    {DCM_ImagePositionPatient, Axis::place},
    {DCM_EnergyWindowVector, Axis::stack},
    {DCM_DetectorVector, Axis::stack},
    {DCM_PhaseVector, Axis::time},
    {DCM_RRIntervalVector, Axis::time},
    {DCM_TimeSlotVector, Axis::time},
    {DCM_TimeSliceVector, Axis::time},
};

struct Frames {
    const Fields &fields;
    std::vector<Slice> &slices;
    std::string refused;
    bool has_slice_vector = false, has_phases = false;
};

/* One whole number for every frame (NM vectors are US). */
bool whole_numbers(const Frames &frames, const DcmTagKey &key, std::vector<unsigned> &out)
{
    DcmElement *element = frames.fields.find(key);
    out.resize(frames.slices.size());
    for (size_t f = 0; f < out.size(); f++) {
        Uint16 value = 0;
        if (!element || element->getUint16(value, (unsigned long)f).bad())
            return false;
        out[f] = value;
    }
    return true;
}

/* The frames of one energy window, detector, … are a stack of their own. */
void take_phase(Frames &frames, const DcmTagKey &key, Axis axis)
{
    std::vector<unsigned> values;
    if (!whole_numbers(frames, key, values)) {
        frames.refused = format("%s (%04X,%04X), which FrameIncrementPointer (0028,0009) names, has not one value for "
                                "each frame",
                                DcmTag(key).getTagName(), unsigned(key.getGroup()), unsigned(key.getElement()));
        return;
    }
    for (size_t f = 0; f < values.size(); f++) {
        std::string &phase = frames.slices[f].phase[axis == Axis::stack ? PHASE_STACK : PHASE_TEMPORAL];
        phase += (phase.empty() ? "" : ".") + std::to_string(values[f]);
    }
    frames.has_phases = true;
}

void follow(Frames &frames, const DcmTagKey &key)
{
    for (const auto &known : axes) {
        if (known.key != key)
            continue;
        if (known.axis != Axis::place)
            take_phase(frames, key, known.axis);
        frames.has_slice_vector = frames.has_slice_vector || key == DCM_SliceVector;
        return;
    }
    frames.refused =
        format("NumberOfFrames (0028,0008) is %zu, and FrameIncrementPointer (0028,0009) names %s "
               "(%04X,%04X): the frames are no slices of a volume",
               frames.slices.size(), DcmTag(key).getTagName(), unsigned(key.getGroup()), unsigned(key.getElement()));
}

void follow_pointers(Frames &frames)
{
    DcmElement *element = frames.fields.find(DCM_FrameIncrementPointer);
    auto *pointers = dynamic_cast<DcmAttributeTag *>(element);
    if (element && !pointers)
        frames.refused = "FrameIncrementPointer (0028,0009) is damaged";
    for (unsigned long i = 0; pointers && i < pointers->getVM() && i < 16 && frames.refused.empty(); i++) {
        DcmTagKey key;
        if (pointers->getTagVal(key, i).good())
            follow(frames, key);
    }
}

/* Offsets from the first frame (they begin with 0), or, of axial frames, patient coordinates. */
void place_by_grid(Frames &frames, std::vector<double> &offsets)
{
    const Slice &first = frames.slices[0];
    const double begin = offsets[0];
    if (begin != 0 && (first.normal.z < 0.999 || std::fabs(begin - first.position.z) > 0.01)) {
        frames.refused = "GridFrameOffsetVector (3004,000C) begins neither with 0 nor with the first frame's z";
        return;
    }
    for (double &offset : offsets)
        offset -= begin;
}

/* Steps of SpacingBetweenSlices, whose sign says on which side of the first frame the others lie (C.8.4.15); in the
 * order of SliceVector, or as the frames come. */
void place_by_spacing(Frames &frames, double spacing, std::vector<double> &offsets)
{
    std::vector<unsigned> places;
    const bool numbered = frames.has_slice_vector && whole_numbers(frames, DCM_SliceVector, places);
    const int slices = frames.fields.integer(DCM_NumberOfSlices, 0);
    if (!numbered &&
        (frames.has_phases || frames.has_slice_vector || frames.fields.integer(DCM_NumberOfTemporalPositions, 1) > 1 ||
         (slices > 0 && size_t(slices) != frames.slices.size()))) {
        frames.refused = format("NumberOfFrames (0028,0008) is %zu, in several phases, and no SliceVector (0054,0080) "
                                "says which slice a frame is of",
                                frames.slices.size());
        return;
    }
    for (size_t f = 0; f < offsets.size(); f++)
        offsets[f] = spacing * (numbered ? double(places[f]) - double(places[0]) : double(f));
    for (Slice &slice : frames.slices)
        slice.frames_assumed = !numbered;
}

bool has_all(const Frames &frames, const DcmTagKey &key, std::vector<double> &out)
{
    return frames.fields.numbers(key, out.data(), unsigned(out.size()));
}

void place(Frames &frames)
{
    std::vector<double> offsets(frames.slices.size());
    const Slice &first = frames.slices[0];
    const char *missing = nullptr;
    double spacing = 0;
    if (!first.has_position)
        missing = "ImagePositionPatient (0020,0032) is missing";
    else if (!first.has_orientation)
        missing = "ImageOrientationPatient (0020,0037) is missing";
    else if (has_all(frames, DCM_GridFrameOffsetVector, offsets))
        place_by_grid(frames, offsets);
    else if (has_all(frames, DCM_SliceLocationVector, offsets))
        for (size_t f = offsets.size(); f-- > 0;) {
            offsets[f] -= offsets[0];
            frames.slices[f].frames_assumed = true;
        }
    else if (frames.fields.numbers(DCM_SpacingBetweenSlices, &spacing, 1) && std::fabs(spacing) > 1e-6)
        place_by_spacing(frames, spacing, offsets);
    else
        missing = "SpacingBetweenSlices (0018,0088) is missing";
    if (missing)
        frames.refused = format("NumberOfFrames (0028,0008) is %zu, and nothing says where each frame lies: there are "
                                "no functional groups, and %s",
                                frames.slices.size(), missing);
    for (size_t f = 0; f < offsets.size() && frames.refused.empty(); f++)
        frames.slices[f].position = vit_vec3_add(first.position, vit_vec3_scale(first.normal, offsets[f]));
}

} // namespace

std::vector<DcmItem *> frames_whole(DcmItem &data)
{
    std::vector<DcmItem *> places{&data};
    DcmElement *element = nullptr;
    if (data.findAndGetElement(DCM_DetectorInformationSequence, element).bad())
        return places;
    auto *detectors = dynamic_cast<DcmSequenceOfItems *>(element);
    if (detectors && detectors->card() == 1)
        places.push_back(detectors->getItem(0));
    return places;
}

std::string frames_offsets(const Fields &fields, std::vector<Slice> &slices)
{
    Frames frames{fields, slices, {}};
    follow_pointers(frames);
    if (frames.refused.empty())
        place(frames);
    return frames.refused;
}

} // namespace vitdicom
