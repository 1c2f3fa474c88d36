/* JSON on stdout, through jansson. */
#include "app_private.h"

#include <math.h>
#include <string.h>

#define JSON_DIGITS 12

json_t *app_json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *app_json_text(const char *text, size_t bytes)
{
    if (!text)
        return json_null();
    json_t *string = json_stringn(text, bytes);
    char *copy = string ? NULL : vit_alloc_zero(bytes + 1, 1);
    for (size_t i = 0; copy && i < bytes; i++)
        copy[i] = (unsigned char)text[i] < 0x80 ? text[i] : '?';
    if (copy)
        string = json_stringn(copy, bytes);
    vit_free(copy);
    return string;
}

json_t *app_json_string(const char *text)
{
    return app_json_text(text, text ? strlen(text) : 0);
}

json_t *app_json_left_out(const struct vit_plan *plan)
{
    json_t *list = json_array();
    for (int i = 0; i < plan->left_out_count; i++) {
        const struct vit_left_out *left = &plan->left_out[i];
        json_array_append_new(list,
                              json_pack("{s:s, s:s, s:o, s:I, s:o, s:o}", "what", left->what, "why", left->why, "rule",
                                        app_json_string(left->rule), "bytes_saved", (json_int_t)left->bytes_saved,
                                        "fragments_saved", app_json_number(left->fragments_saved), "ms_saved",
                                        left->ms_known ? app_json_number(left->ms_saved) : json_null()));
    }
    return list;
}

enum vit_exit app_json_print(struct app *app, json_t *object)
{
    if (!object) {
        vit_error(&app->log, "out of memory for the JSON answer");
        return VIT_EXIT_FAILED;
    }
    json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(JSON_DIGITS));
    putchar('\n');
    json_decref(object);
    return VIT_EXIT_DONE;
}
