/* The C side: every function here is extern "C" and lets no exception out. */
#include "archive_private.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <omp.h>

using namespace vitdicom;

namespace {

/* Shared by the threads of one loop: how far we are, and whether to stop. */
struct Loop {
    const vit_progress *progress;
    const char *task;
    uint64_t total;
    std::atomic<uint64_t> done{0};
    std::atomic<bool> cancelled{false}, failed{false};
    Loop(const vit_progress *to, const char *name, uint64_t count) : progress(to), task(name), total(count) {}
    bool stopped() const
    {
        return cancelled.load(std::memory_order_relaxed) || failed.load(std::memory_order_relaxed);
    }
    void step()
    {
        if (!vit_progress_step(progress, task, ++done, total))
            cancelled = true;
    }
};

/* Equal tables are kept once: a series may repeat one of 128 kB in every file. */
struct Tables {
    std::mutex lock;
    std::vector<std::shared_ptr<const Table>> tables;
};

void share_tables(Tables &shared, std::vector<Slice> &slices)
{
    std::vector<std::shared_ptr<const Table>> &tables = shared.tables;
    for (Slice &slice : slices) {
        if (!slice.lut)
            continue;
        std::lock_guard<std::mutex> guard(shared.lock);
        auto same = [&slice](const std::shared_ptr<const Table> &table) {
            return table == slice.lut || *table == *slice.lut;
        };
        auto found = std::find_if(tables.begin(), tables.end(), same);
        if (found == tables.end())
            tables.push_back(slice.lut);
        else
            slice.lut = *found;
    }
}

bool read_headers(vit_dicom_scan &scan, const std::vector<Found> &files, const vit_log *log,
                  const vit_progress *progress)
{
    std::vector<std::vector<Slice>> slices(files.size());
    std::vector<std::string> reasons(files.size());
    std::vector<char> ok(files.size(), 0);
    Tables tables;
    Loop loop(progress, "scan", files.size());
#pragma omp parallel for schedule(dynamic, 4) if (files.size() > 8)
    for (size_t i = 0; i < files.size(); i++) {
        if (loop.stopped())
            continue;
        try {
            ok[i] = header_read(files[i], slices[i], reasons[i]);
            share_tables(tables, slices[i]);
        } catch (...) {
            loop.failed = true;
        }
        loop.step();
    }
    if (loop.stopped()) {
        vit_error(log, "dicom: %s", loop.failed ? "not enough memory to read the headers" : "scan cancelled");
        return false;
    }
    for (size_t i = 0; i < files.size(); i++)
        if (ok[i])
            std::move(slices[i].begin(), slices[i].end(), std::back_inserter(scan.slices));
        else
            scan.rejected.push_back(one_line(files[i].path) + ": " + reasons[i]);
    return true;
}

bool ends_with(const std::string &text, const char *end)
{
    size_t length = strlen(end);
    return text.size() >= length && text.compare(text.size() - length, length, end) == 0;
}

/* "NULL when nothing in them is DICOM": a DICOM file that is no image still makes a scan (with its reason). */
bool anything_dicom(const vit_dicom_scan &scan)
{
    return !scan.slices.empty() || std::any_of(scan.rejected.begin(), scan.rejected.end(), [](const std::string &line) {
        return !ends_with(line, ": not DICOM") && !ends_with(line, ": cannot be read") &&
               line.find(": cannot ") == std::string::npos;
    });
}

vit_dicom_scan *scan_create(const char *const *paths, size_t count, const vit_log *log, const vit_progress *progress)
{
    if (!library_init(log) || vit_fault())
        return nullptr;
    auto scan = std::make_unique<vit_dicom_scan>();
    std::vector<Found> files;
    if (!walk(paths, count, files, scan->rejected, log) || !read_headers(*scan, files, log, progress))
        return nullptr;
    if (!anything_dicom(*scan)) {
        std::string where = count ? one_line(paths[0]) : "no path given";
        if (files.size() == 1 && scan->rejected.size() == 1)
            vit_error(log, "%s", scan->rejected[0].c_str());
        else
            vit_error(log, "%s: no DICOM file found (%zu files looked at)", where.c_str(), files.size());
        return nullptr;
    }
    scan->stacks = group(scan->slices);
    for (const Slice &slice : scan->slices) /* split() may have looked at pixels */
        file_release(slice);
    return scan.release();
}

/* Higher is better: readable, CT cross section, axial, then voxels. */
bool is_better(const Stack &a, const Stack &b)
{
    auto rank = [](const Stack &s) {
        bool ct = s.modality == "CT" && s.plain.info.is_hu && !s.localizer;
        return (s.plain.readable ? 8 : 0) + (ct ? 4 : 0) + (ct && s.plane == "axial" ? 2 : 0) + (s.localizer ? 0 : 1);
    };
    if (rank(a) != rank(b))
        return rank(a) > rank(b);
    auto voxels = [](const Stack &s) { return s.plain.info.n[0] * s.plain.info.n[1] * s.plain.info.n[2]; };
    return voxels(a) > voxels(b);
}

ptrdiff_t find_series(const vit_dicom_scan &scan, const char *series)
{
    if (!series) {
        ptrdiff_t best = scan.stacks.empty() ? -1 : 0;
        for (size_t i = 1; i < scan.stacks.size(); i++)
            if (is_better(*scan.stacks[i], *scan.stacks[size_t(best)]))
                best = ptrdiff_t(i);
        return best;
    }
    char *end = nullptr;
    unsigned long number = strtoul(series, &end, 10);
    if (isdigit(static_cast<unsigned char>(*series)) && *end == '\0')
        return number >= 1 && number <= scan.stacks.size() ? ptrdiff_t(number) - 1 : -1;
    ptrdiff_t best = -1;
    for (size_t i = 0; i < scan.stacks.size(); i++)
        if (scan.stacks[i]->series_uid == series &&
            (best < 0 || is_better(*scan.stacks[i], *scan.stacks[size_t(best)])))
            best = ptrdiff_t(i);
    return best;
}

ptrdiff_t scan_choose(const vit_dicom_scan &scan, const char *series, const vit_log *log)
{
    ptrdiff_t index = find_series(scan, series);
    size_t count = scan.stacks.size();
    if (count == 0 && scan.rejected.size() == 1)
        vit_error(log, "%s", scan.rejected[0].c_str());
    else if (count == 0)
        vit_error(log, "dicom: no image stack in %zu files, for instance %s", scan.rejected.size(),
                  scan.rejected.empty() ? "(none)" : scan.rejected[0].c_str());
    else if (index < 0)
        vit_error(log, "dicom: no such series; give a number from 1 to %zu, or a series UID among them", count);
    else if (!scan.stacks[size_t(index)]->plain.readable)
        vit_error(log, "dicom: stack %td cannot be read: %s", index + 1, scan.stacks[size_t(index)]->refused.c_str());
    else
        return index;
    return -1;
}

bool stack_read(const Stack &stack, void *samples, size_t bytes, const vit_slice_sink *sink, const vit_log *log,
                const vit_progress *progress)
{
    if (!stack.plain.readable) {
        vit_error(log, "dicom: stack cannot be read: %s", stack.refused.c_str());
        return false;
    }
    if (bytes != vit_volume_info_bytes(&stack.plain.info)) {
        vit_error(log, "dicom: a buffer of %zu bytes for a stack of %zu", bytes,
                  vit_volume_info_bytes(&stack.plain.info));
        return false;
    }
    size_t slice_bytes = stack.plain.info.n[0] * stack.plain.info.n[1] * 2;
    Loop loop(progress, "read", stack.slices.size());
    std::atomic<size_t> clamped_all{0};
    size_t count = stack.slices.size();
#pragma omp parallel for schedule(dynamic, 1) if (count > 4)
    for (size_t k = 0; k < count; k++) {
        if (loop.stopped())
            continue;
        std::string why;
        size_t clamped = 0;
        char *out = static_cast<char *>(samples) + k * slice_bytes;
        bool done = stack.origins.empty() ? slice_read(*stack.slices[k], stack.encoding, out, nullptr, clamped, why)
                                          : lattice_read(stack, k, samples, clamped, why);
        if (!done && !loop.failed.exchange(true))
            vit_error(log, "%s: %s", one_line(stack.slices[k]->file.path).c_str(), one_line(why).c_str());
        if (done && sink && stack.origins.empty())
            sink->ready(sink->user, k, k + 1);
        clamped_all += clamped;
        loop.step();
    }
    for (const Slice *slice : stack.slices)
        file_release(*slice);
    if (loop.cancelled && !loop.failed)
        vit_error(log, "dicom: reading cancelled");
    if (clamped_all > 0)
        vit_warn(log, "dicom: %zu samples were clamped to the range of the common rescale", clamped_all.load());
    return !loop.stopped();
}

} // namespace

extern "C" {

struct vit_dicom_scan *vit_dicom_scan_create(const char *const *paths, size_t path_count, const struct vit_log *log,
                                             const struct vit_progress *progress)
{
    try {
        return scan_create(paths, path_count, log, progress);
    } catch (...) {
        vit_error(log, "dicom: not enough memory to scan");
        return nullptr;
    }
}

size_t vit_dicom_scan_stack_count(const struct vit_dicom_scan *scan)
{
    return scan ? scan->stacks.size() : 0;
}

const struct vit_dicom_stack *vit_dicom_scan_stack(const struct vit_dicom_scan *scan, size_t index)
{
    return scan && index < scan->stacks.size() ? &scan->stacks[index]->plain : nullptr;
}

size_t vit_dicom_scan_rejected_count(const struct vit_dicom_scan *scan)
{
    return scan ? scan->rejected.size() : 0;
}

const char *vit_dicom_scan_rejected(const struct vit_dicom_scan *scan, size_t index)
{
    return scan && index < scan->rejected.size() ? scan->rejected[index].c_str() : nullptr;
}

ptrdiff_t vit_dicom_scan_choose(const struct vit_dicom_scan *scan, const char *series, const struct vit_log *log)
{
    try {
        return scan ? scan_choose(*scan, series, log) : -1;
    } catch (...) {
        vit_error(log, "dicom: not enough memory");
        return -1;
    }
}

bool vit_dicom_stack_read(const struct vit_dicom_scan *scan, size_t index, void *samples, size_t bytes,
                          const struct vit_slice_sink *sink, const struct vit_log *log,
                          const struct vit_progress *progress)
{
    if (!scan || index >= scan->stacks.size() || !samples)
        return false;
    try {
        return stack_read(*scan->stacks[index], samples, bytes, sink, log, progress);
    } catch (...) {
        vit_error(log, "dicom: not enough memory to read");
        return false;
    }
}

void vit_dicom_scan_destroy(struct vit_dicom_scan **scan)
{
    if (!scan)
        return;
    delete *scan;
    *scan = nullptr;
}

bool vit_dicom_probe(const char *path)
{
    try {
        return path && (is_folder(path) || probe_file(path) == Probe::dicom || is_zip(path));
    } catch (...) {
        return false;
    }
}

bool vit_dicom_write(const struct vit_volume *volume, const char *folder, const struct vit_log *log,
                     const struct vit_progress *progress)
{
    try {
        return volume && folder && write_series(volume, folder, log, progress);
    } catch (...) {
        vit_error(log, "dicom: not enough memory to write");
        return false;
    }
}
}
