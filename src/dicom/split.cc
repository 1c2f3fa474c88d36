/* Acquisitions and phases that share a series are told apart here: by whatever attribute explains why two slices lie at
 * one place. Nothing is ever interleaved on a guess: what cannot be told apart stays together, and geometry() refuses
 * it unless the slices that meet are the same picture. */
#include "archive_private.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>

namespace vitdicom {

namespace {

constexpr int DEEPEST = 3; /* attributes at once: phase, kernel, kV */

bool same_bytes(const Slice &a, const Slice &b)
{
    if (a.file_bytes != b.file_bytes || a.frame != b.frame)
        return false;
    File file_a, file_b;
    std::string why;
    if (!file_a.open(a, why) || !file_b.open(b, why))
        return false;
    char block_a[16384], block_b[16384];
    for (uint64_t at = 0; at < a.file_bytes; at += sizeof block_a) {
        const size_t bytes = size_t(std::min<uint64_t>(a.file_bytes - at, sizeof block_a));
        if (!read_all_at(file_a.fd(), block_a, bytes, at) || !read_all_at(file_b.fd(), block_b, bytes, at) ||
            memcmp(block_a, block_b, bytes) != 0)
            return false;
    }
    return true;
}

/* The same picture, whatever it is written in: equal values at every pixel. */
bool same_pixels(const Slice &a, const Slice &b)
{
    if (a.rows != b.rows || a.columns != b.columns || a.slope != b.slope || a.intercept != b.intercept ||
        a.lut != b.lut || !a.refused.empty() || !b.refused.empty() || a.format.is_wide() || b.format.is_wide())
        return false;
    Encoding encoding;
    encoding.sample = std::max(a.highest(), b.highest()) > 32767 ? VIT_SAMPLE_U16 : VIT_SAMPLE_I16;
    std::vector<uint16_t> samples_a(a.rows * a.columns), samples_b(samples_a.size());
    size_t clamped = 0;
    std::string why;
    return slice_read(a, encoding, samples_a.data(), nullptr, clamped, why) &&
           slice_read(b, encoding, samples_b.data(), nullptr, clamped, why) && samples_a == samples_b;
}

/* Of slices in order, all but the first of those at one place that `same` holds for. Returns how many went. */
size_t drop(Slices &ordered, bool (*same)(const Slice &, const Slice &))
{
    size_t kept = 0;
    for (size_t k = 0; k < ordered.size(); k++) {
        bool copy = false;
        for (size_t j = kept; j > 0 && !copy && place_mm(*ordered[k], *ordered[j - 1]) < 1e-4; j--)
            copy = same(*ordered[k], *ordered[j - 1]);
        if (!copy)
            ordered[kept++] = ordered[k];
    }
    size_t dropped = ordered.size() - kept;
    ordered.resize(kept);
    return dropped;
}

bool same_file(const Slice &a, const Slice &b)
{
    return !a.instance_uid.empty() && a.instance_uid == b.instance_uid && same_bytes(a, b);
}

bool is_single_valued(const Slices &slices)
{
    return find_duplicate(slices) == slices.size();
}

/* The most slices at one place. */
size_t multiplicity(const Slices &ordered)
{
    size_t most = 1, here = 1;
    for (size_t k = 1; k < ordered.size(); k++) {
        here = place_mm(*ordered[k], *ordered[k - 1]) < 1e-3 ? here + 1 : 1;
        most = std::max(most, here);
    }
    return most;
}

/* What a value of a phase is called. Descriptions are free text, which may say who the patient is. */
std::string label_of(size_t phase, const std::string &value, size_t number)
{
    bool free_text = strcmp(phase_names[phase], "series description") == 0;
    if (value.empty())
        return std::string("no ") + phase_names[phase];
    return std::string(phase_names[phase]) + " " + (free_text ? std::to_string(number) : one_line(value.substr(0, 64)));
}

std::vector<Part> partition(const Part &whole, size_t phase)
{
    std::map<std::string, Slices> table;
    for (const Slice *slice : whole.slices)
        table[slice->phase[phase]].push_back(slice);
    std::vector<Part> parts;
    for (auto &entry : table) {
        Part part = whole;
        part.slices = std::move(entry.second);
        part.label += (part.label.empty() ? "" : ", ") + label_of(phase, entry.first, parts.size() + 1);
        parts.push_back(std::move(part));
    }
    return parts;
}

bool all_parts(const std::vector<Part> &parts, bool (*is_good)(const Slices &))
{
    return parts.size() > 1 &&
           std::all_of(parts.begin(), parts.end(), [is_good](const Part &part) { return is_good(part.slices); });
}

bool is_several(const Slices &slices)
{
    return slices.size() > 1;
}

bool is_even_part(const Slices &slices)
{
    return is_several(slices) && is_single_valued(slices) && is_even(slices);
}

/* Parts in which no two slices share a place, told apart by at most `depth` attributes from `phase` on. A part of one
 * slice is believed only where there are no more parts than slices at one place: else an attribute that differs in
 * every slice (a time) would tell everything apart. */
bool tell_apart(const Part &whole, size_t phase, int depth, std::vector<Part> &out)
{
    const size_t most = multiplicity(whole.slices);
    for (; phase < PHASES && depth > 0; phase++) {
        std::vector<Part> parts = partition(whole, phase), told;
        bool good = parts.size() > 1 && (parts.size() <= most || all_parts(parts, is_several));
        for (size_t i = 0; i < parts.size() && good; i++) {
            if (is_single_valued(parts[i].slices))
                told.push_back(std::move(parts[i]));
            else
                good = tell_apart(parts[i], phase + 1, depth - 1, told);
        }
        if (!good)
            continue;
        std::move(told.begin(), told.end(), std::back_inserter(out));
        return true;
    }
    return false;
}

/* A time as one number: hours, minutes and seconds are digits in falling weight. */
bool time_of(const Slice &slice, size_t phase, double &out)
{
    const std::string &text = slice.phase[phase];
    char *end = nullptr;
    out = strtod(text.c_str(), &end);
    return !text.empty() && end != text.c_str() && std::isfinite(out);
}

/* Every place was visited equally often, at times that differ: the nth visit to each is the nth part. */
bool deal_by_time(const Part &whole, size_t phase, std::vector<Part> &out)
{
    const Slices &all = whole.slices;
    size_t visits = multiplicity(all);
    if (visits < 2 || all.size() % visits != 0 || all.size() == visits)
        return false;
    std::vector<Part> parts(visits, whole);
    for (Part &part : parts)
        part.slices.clear();
    for (size_t k = 0; k < all.size(); k += visits) {
        std::vector<std::pair<double, const Slice *>> here;
        for (size_t j = k; j < k + visits; j++) {
            double time;
            if (!time_of(*all[j], phase, time) || place_mm(*all[j], *all[k]) > 1e-3)
                return false;
            here.emplace_back(time, all[j]);
        }
        std::sort(here.begin(), here.end(), [](const auto &a, const auto &b) { return a.first < b.first; });
        for (size_t j = 0; j < visits; j++) {
            if (j > 0 && here[j].first == here[j - 1].first)
                return false;
            parts[j].slices.push_back(here[j].second);
        }
    }
    for (size_t j = 0; j < visits; j++) {
        parts[j].label += format("%svisit %zu by %s", whole.label.empty() ? "" : ", ", j + 1, phase_names[phase]);
        parts[j].by_time = phase;
        if (!is_single_valued(parts[j].slices))
            return false;
    }
    std::move(parts.begin(), parts.end(), std::back_inserter(out));
    return true;
}

/* Acquisitions that follow one another along the table are one stack; one that comes again after another was met
 * overlaps it, and they are two. */
bool acquisitions_interleave(const Slices &ordered)
{
    std::map<std::string, bool> left;
    for (size_t k = 1; k < ordered.size(); k++) {
        const std::string &before = ordered[k - 1]->phase[PHASE_ACQUISITION],
                          &now = ordered[k]->phase[PHASE_ACQUISITION];
        if (before == now)
            continue;
        left[before] = true;
        if (left[now])
            return true;
    }
    return false;
}

/* Gaps of one size on each side of slice k, from `from` on. */
size_t run(const Slices &ordered, size_t k, int way)
{
    size_t length = 0;
    double first = 0;
    for (size_t j = k; way < 0 ? j > 0 : j + 1 < ordered.size(); j = way < 0 ? j - 1 : j + 1) {
        double gap = way < 0 ? place_mm(*ordered[j], *ordered[j - 1]) : place_mm(*ordered[j + 1], *ordered[j]);
        if (length > 0 && !same_gap(gap, first))
            break;
        first = length == 0 ? gap : first;
        length++;
    }
    return length;
}

/* Where one acquisition ends and another begins, and the distance jumps or becomes another one there, two things were
 * scanned. The same within one acquisition is slices missing, which is not for us to decide. */
bool is_seam(const Slices &ordered, size_t k)
{
    auto same = [&ordered](size_t a, size_t b) {
        return ordered[a]->phase[PHASE_ACQUISITION] == ordered[b]->phase[PHASE_ACQUISITION];
    };
    /* A number for every slice tells nothing. */
    if (k < 2 || k + 1 >= ordered.size() || same(k - 1, k) || !same(k - 2, k - 1) || !same(k, k + 1))
        return false;
    double before = place_mm(*ordered[k - 1], *ordered[k - 2]), after = place_mm(*ordered[k + 1], *ordered[k]);
    double here = place_mm(*ordered[k], *ordered[k - 1]);
    if (here > 3.5 * std::max(before, after))
        return true;
    return !same_gap(before, after) && run(ordered, k - 1, -1) >= 3 && run(ordered, k, 1) >= 3;
}

std::vector<Part> cut_at_seams(const Part &whole)
{
    std::vector<Part> parts;
    size_t from = 0;
    for (size_t k = 1; k <= whole.slices.size(); k++) {
        if (k < whole.slices.size() && !is_seam(whole.slices, k))
            continue;
        Part part = whole;
        part.slices.assign(whole.slices.begin() + long(from), whole.slices.begin() + long(k));
        if (from > 0 || k < whole.slices.size())
            part.label += (part.label.empty() ? "" : ", ") +
                          label_of(PHASE_ACQUISITION, part.slices[0]->phase[PHASE_ACQUISITION], 0);
        parts.push_back(std::move(part));
        from = k;
    }
    return parts;
}

std::vector<Part> split_part(Part whole)
{
    std::vector<Part> parts = partition(whole, PHASE_ACQUISITION), told;
    if (acquisitions_interleave(whole.slices) && all_parts(parts, is_several)) {
        for (Part &part : parts) {
            std::vector<Part> pieces = split_part(std::move(part));
            std::move(pieces.begin(), pieces.end(), std::back_inserter(told));
        }
        return told;
    }
    if (!is_single_valued(whole.slices)) {
        for (int depth = 1; depth <= DEEPEST; depth++)
            if (tell_apart(whole, 0, depth, told))
                return told;
            else
                told.clear();
        for (size_t phase : {PHASE_TIME, PHASE_TIME - 1, PHASES - 1})
            if (deal_by_time(whole, phase, told))
                return told;
        whole.copies += drop(whole.slices, same_pixels);
    }
    if (is_single_valued(whole.slices) && !is_even(whole.slices))
        return all_parts(parts, is_even_part) ? parts : cut_at_seams(whole);
    told.push_back(std::move(whole));
    return told;
}

} // namespace

std::vector<Part> split(Slices slices)
{
    Part whole;
    whole.slices = std::move(slices);
    order(whole.slices);
    whole.copies = drop(whole.slices, same_file);
    std::vector<Part> parts = split_part(std::move(whole));
    for (size_t i = 1; i < parts.size(); i++)
        parts[i].copies = 0; /* said once */
    return parts;
}

} // namespace vitdicom
