/* Fuzzer: any bytes as a DICOM file, scanned, and its pixels read when they are few. Nothing may crash, hang or leak,
 * and what a stack claims to hold must be bounded by the file before anything is allocated for it. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "vitrine/dicom.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes);

static void read_stack(const struct vit_dicom_scan *scan, size_t index, size_t file_bytes, bool is_zip)
{
    const struct vit_dicom_stack *stack = vit_dicom_scan_stack(scan, index);
    if (!stack->readable || !vit_volume_info_check(&stack->info, NULL))
        return;
    size_t need = vit_volume_info_bytes(&stack->info);
    /* 2^18 samples per byte: JPEG-LS run mode, the densest of the codings; 2^10 bytes per byte of a zip. */
    if (need / 2 > file_bytes << (is_zip ? 28 : 18))
        abort();
    void *samples = need <= 1 << 22 ? vit_alloc(need, 1) : NULL;
    if (samples)
        (void)!vit_dicom_stack_read(scan, index, samples, need, NULL, NULL, NULL);
    vit_free(samples);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    char path[64];
    const char *paths[] = {path};
    int fd = memfd_create("dicom", MFD_CLOEXEC);
    if (fd < 0)
        return 0;
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    if (write(fd, data, bytes) == (ssize_t)bytes) {
        struct vit_dicom_scan *scan = vit_dicom_scan_create(paths, 1, NULL, NULL);
        for (size_t i = 0; i < vit_dicom_scan_stack_count(scan); i++)
            read_stack(scan, i, bytes, bytes > 2 && data[0] == 'P' && data[1] == 'K');
        vit_dicom_scan_destroy(&scan);
    }
    close(fd);
    return 0;
}
