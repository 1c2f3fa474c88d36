/* ModalityLUTSequence (PS3.3 C.11.1): stored values that become modality values by a table instead of a slope. Its
 * output is unsigned. Read once a file; equal tables of a scan are one (shim.cc). */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdeftag.h"
#include "dcmtk/dcmdata/dcelem.h"
#include "dcmtk/dcmdata/dcsequen.h"

#include "fields_private.h"

#include <algorithm>

namespace vitdicom {

namespace {

/* The 16-bit words of an attribute, whichever VR (US, SS, OW) the file gave it. */
std::vector<uint16_t> words_of(DcmElement *element)
{
    Uint16 *words = nullptr;
    Sint16 *signed_words = nullptr;
    const size_t count = element ? element->getLength() / 2 : 0;
    if (count > 0 && element->getUint16Array(words).good() && words)
        return std::vector<uint16_t>(words, words + count);
    if (count > 0 && element->getSint16Array(signed_words).good() && signed_words)
        return std::vector<uint16_t>(signed_words, signed_words + count);
    return {};
}

/* Entries of 8 bits may be packed two to a word, the first in the low byte. */
bool take_values(const std::vector<uint16_t> &words, size_t entries, unsigned bits, std::vector<uint16_t> &out)
{
    if (words.size() >= entries) {
        out.assign(words.begin(), words.begin() + long(entries));
        return true;
    }
    if (bits != 8 || words.size() != (entries + 1) / 2)
        return false;
    for (size_t i = 0; i < entries; i++)
        out.push_back(i % 2 ? words[i / 2] >> 8 : words[i / 2] & 255);
    return true;
}

/* MONOCHROME1: mirrored within what the table's bits can say. */
void mirror(Table &table, unsigned bits)
{
    const uint16_t most = uint16_t(std::max<unsigned>(table.high, (1u << bits) - 1));
    for (uint16_t &value : table.values)
        value = uint16_t(most - value);
}

} // namespace

void fields_table(const Fields &fields, Slice &slice)
{
    auto *sequence = dynamic_cast<DcmSequenceOfItems *>(fields.find(DCM_ModalityLUTSequence));
    DcmItem *item = sequence && sequence->card() > 0 ? sequence->getItem(0) : nullptr;
    if (!item)
        return;
    const Fields lut(*item);
    slice.is_hu = slice.modality == "CT" && lut.text(DCM_ModalityLUTType) == "HU";
    slice.format.inverted = slice.monochrome1 && !slice.is_hu;
    if (slice.lut)
        return; /* of the frame before */
    const std::vector<uint16_t> descriptor = words_of(lut.find(DCM_LUTDescriptor));
    if (slice.has_rescale && (slice.slope != 1 || slice.intercept != 0)) {
        slice.refused = "ModalityLUTSequence (0028,3000) and a rescale slope contradict one another";
        return;
    }
    if (slice.format.is_wide() || descriptor.size() != 3 || descriptor[2] < 8 || descriptor[2] > 16) {
        slice.refused = slice.format.is_wide() ? "ModalityLUTSequence (0028,3000) for pixels of more than 16 bits"
                                               : "LUTDescriptor (0028,3002) is damaged";
        return;
    }
    auto table = std::make_shared<Table>();
    const size_t entries = descriptor[0] ? descriptor[0] : 65536;
    table->first = slice.format.is_signed ? int32_t(int16_t(descriptor[1])) : int32_t(descriptor[1]);
    if (!take_values(words_of(lut.find(DCM_LUTData)), entries, descriptor[2], table->values)) {
        slice.refused =
            format("LUTData (0028,3006) has not the %zu entries that LUTDescriptor (0028,3002) says", entries);
        return;
    }
    table->high = *std::max_element(table->values.begin(), table->values.end());
    if (slice.format.inverted)
        mirror(*table, descriptor[2]);
    const auto ends = std::minmax_element(table->values.begin(), table->values.end());
    table->low = *ends.first;
    table->high = *ends.second;
    slice.lut = table;
}

} // namespace vitdicom
