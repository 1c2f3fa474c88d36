/* What the tests of config share: a log that keeps the last line and counts them, and presets as text to compare. */
#ifndef VITRINE_TESTS_CONFIG_FIXTURE_H
#define VITRINE_TESTS_CONFIG_FIXTURE_H

#include "vitrine/config.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

struct kept {
    char last[1100];
    int lines;
};

static inline void kept_write(void *user, enum vit_log_level level, const char *line)
{
    struct kept *kept = user;
    (void)level;
    snprintf(kept->last, sizeof kept->last, "%s", line);
    kept->lines++;
}

static inline struct vit_log kept_log(struct kept *kept)
{
    kept->last[0] = '\0';
    kept->lines = 0;
    return (struct vit_log){kept_write, kept, VIT_LOG_DEBUG};
}

/* What `print` writes, as text from malloc. */
static inline char *printed(void (*print)(FILE *, const void *), const void *user)
{
    char *text = NULL;
    size_t bytes = 0;
    FILE *out = open_memstream(&text, &bytes);
    assert_non_null(out);
    print(out, user);
    assert_int_equal(fclose(out), 0);
    return text;
}

static inline void print_preset(FILE *out, const void *preset)
{
    assert_true(vit_preset_write(preset, out));
}

static inline char *preset_text(const struct vit_preset *preset)
{
    return printed(print_preset, preset);
}

#endif
