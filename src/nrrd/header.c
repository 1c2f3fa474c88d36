/* header: fields of the text into a checked vit_nrrd_header. Format: teem, "Definition of NRRD File Format", "Basic
 * fields" and "Per-axis fields". */
#include "nrrd_private.h"

#include <math.h>
#include <string.h>

#define ALIASES 5
static const struct type_names {
    enum vit_nrrd_type type;
    size_t bytes;
    const char *names[ALIASES];
} types[] = {
    {VIT_NRRD_I8, 1, {"int8", "signed char", "int8_t"}}, /* plain "char" is not in the format: its sign is not known */
    {VIT_NRRD_U8, 1, {"uint8", "uchar", "unsigned char", "uint8_t"}},
    {VIT_NRRD_I16, 2, {"int16", "short", "short int", "signed short", "int16_t"}},
    {VIT_NRRD_I16, 2, {"signed short int"}},
    {VIT_NRRD_U16, 2, {"uint16", "ushort", "unsigned short", "unsigned short int", "uint16_t"}},
    {VIT_NRRD_I32, 4, {"int32", "int", "signed int", "int32_t"}},
    {VIT_NRRD_U32, 4, {"uint32", "uint", "unsigned int", "uint32_t"}},
    {VIT_NRRD_I64, 8, {"int64", "longlong", "long long", "long long int", "int64_t"}},
    {VIT_NRRD_I64, 8, {"signed long long", "signed long long int"}},
    {VIT_NRRD_U64, 8, {"uint64", "ulonglong", "unsigned long long", "unsigned long long int", "uint64_t"}},
    {VIT_NRRD_F32, 4, {"float"}},
    {VIT_NRRD_F64, 8, {"double"}},
};

size_t vit_nrrd_type_bytes(enum vit_nrrd_type type)
{
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(types); i++)
        if (types[i].type == type)
            return types[i].bytes;
    return 0;
}

static bool is_one_of(const char *text, const char *const *names, size_t count)
{
    for (size_t i = 0; i < count && names[i]; i++)
        if (vit_nrrd_word_is(text, strlen(text), names[i]))
            return true;
    return false;
}

static bool parse_type(const struct vit_nrrd_text *text, struct vit_nrrd_header *header)
{
    const char *value = vit_nrrd_text_field(text, VIT_NRRD_FIELD_TYPE);
    if (!value)
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_TYPE, "missing; the header must name the samples' type");
    for (size_t i = 0; i < VIT_ARRAY_LENGTH(types); i++)
        if (is_one_of(value, types[i].names, ALIASES)) {
            header->type = types[i].type;
            return true;
        }
    return vit_nrrd_refuse(text, VIT_NRRD_FIELD_TYPE,
                           "\"%.40s\" cannot be read (int8 to int64, uint8 to uint64, float, double can)", value);
}

static bool parse_encoding(const struct vit_nrrd_text *text, struct vit_nrrd_header *header)
{
    static const char *const gzip[] = {"gzip", "gz"}, *const raw[] = {"raw"};
    static const char *const little[] = {"little"}, *const big[] = {"big"};
    const char *value = vit_nrrd_text_field(text, VIT_NRRD_FIELD_ENCODING);
    if (!value)
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_ENCODING, "missing; write raw or gzip");
    header->gzip = is_one_of(value, gzip, 2);
    if (!header->gzip && !is_one_of(value, raw, 1))
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_ENCODING, "\"%.40s\" cannot be read (raw and gzip can)", value);
    value = vit_nrrd_text_field(text, VIT_NRRD_FIELD_ENDIAN);
    if (!value) {
        if (vit_nrrd_type_bytes(header->type) > 1)
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_ENDIAN, "missing; write little or big");
        return true;
    }
    header->big_endian = is_one_of(value, big, 1);
    if (!header->big_endian && !is_one_of(value, little, 1))
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_ENDIAN, "\"%.40s\" is neither little nor big", value);
    return true;
}

static bool parse_sizes(const struct vit_nrrd_text *text, struct vit_nrrd_header *header, struct vit_nrrd_data *data)
{
    const char *value = vit_nrrd_text_field(text, VIT_NRRD_FIELD_DIMENSION);
    size_t dimension = 0;
    if (!value)
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIMENSION, "missing");
    if (!vit_nrrd_parse_size(&value, &dimension) || *value)
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIMENSION, "not a number");
    if (dimension < 1 || dimension > 4)
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DIMENSION, "%zu axes cannot be read (1 to 4 can)", dimension);
    header->dimension = (int)dimension;
    value = vit_nrrd_text_field(text, VIT_NRRD_FIELD_SIZES);
    if (!value)
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_SIZES, "missing");
    data->samples = 1;
    for (size_t axis = 0; axis < dimension; axis++) {
        if (!vit_nrrd_parse_size(&value, &header->sizes[axis]) || header->sizes[axis] == 0)
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_SIZES, "axis %zu has no size of 1 or more", axis);
        if (!vit_size_mul(&data->samples, data->samples, header->sizes[axis]))
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_SIZES, "more samples than memory has addresses");
    }
    if (*value)
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_SIZES, "more sizes than the %zu axes of `dimension`", dimension);
    if (!vit_size_mul(&data->bytes, data->samples, vit_nrrd_type_bytes(header->type)) || data->bytes > PTRDIFF_MAX)
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_SIZES, "more bytes than memory has addresses");
    return true;
}

/* Axis 0 lists channels if its kind is none of those that lie in space. A 4-dimensional file must say which of its axes
 * is not in space, or the first three are taken. */
static bool parse_kinds(const struct vit_nrrd_text *text, struct vit_nrrd_header *header)
{
    static const char *const in_space[] = {"domain", "space", "time", "???", "none"};
    const char *value = vit_nrrd_text_field(text, VIT_NRRD_FIELD_KINDS);
    if (!value)
        return true;
    for (int axis = 0; axis < header->dimension; axis++) {
        value += strspn(value, " \t");
        size_t length = strcspn(value, " \t");
        if (length == 0)
            return vit_nrrd_refuse(text, VIT_NRRD_FIELD_KINDS, "fewer kinds than the %d axes", header->dimension);
        bool list = true;
        for (size_t i = 0; i < VIT_ARRAY_LENGTH(in_space); i++)
            list = list && !vit_nrrd_word_is(value, length, in_space[i]);
        if (axis == 0)
            header->domain_axis = list ? 1 : 0;
        value += length;
    }
    if (value[strspn(value, " \t")])
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_KINDS, "more kinds than the %d axes", header->dimension);
    return true;
}

static bool parse_rescale(const struct vit_nrrd_text *text, struct vit_nrrd_header *header)
{
    static const enum vit_nrrd_field fields[2] = {VIT_NRRD_FIELD_SLOPE, VIT_NRRD_FIELD_INTERCEPT};
    double *const outs[2] = {&header->slope, &header->intercept};
    header->slope = 1;
    for (int i = 0; i < 2; i++) {
        const char *value = vit_nrrd_text_field(text, fields[i]);
        if (!value)
            continue;
        if (!vit_nrrd_parse_double(&value, outs[i]) || *value || !isfinite(*outs[i]) || (i == 0 && *outs[i] == 0))
            return vit_nrrd_refuse(text, fields[i], "not a finite number%s", i == 0 ? " other than 0" : "");
    }
    const char *is_hu = vit_nrrd_text_field(text, VIT_NRRD_FIELD_IS_HU);
    if (is_hu && strcmp(is_hu, "false") != 0 && strcmp(is_hu, "true") != 0)
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_IS_HU, "neither true nor false");
    header->not_hu = is_hu && strcmp(is_hu, "false") == 0;
    return true;
}

static bool parse_data_place(const struct vit_nrrd_text *text, const struct vit_nrrd_header *header,
                             struct vit_nrrd_data *data)
{
    const char *value = vit_nrrd_text_field(text, VIT_NRRD_FIELD_LINE_SKIP);
    if (value && (!vit_nrrd_parse_size(&value, &data->line_skip) || *value))
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_LINE_SKIP, "not a count of lines");
    value = vit_nrrd_text_field(text, VIT_NRRD_FIELD_BYTE_SKIP);
    if (value && strcmp(value, "-1") == 0 && !header->gzip)
        data->from_end = true;
    else if (value && (!vit_nrrd_parse_size(&value, &data->byte_skip) || *value))
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_BYTE_SKIP, "not a count of bytes (-1 only with encoding raw)");
    value = vit_nrrd_text_field(text, VIT_NRRD_FIELD_DATA_FILE);
    if (!value || vit_nrrd_word_is(value, strlen(value), "LOCAL"))
        return true;
    if (*value == '\0')
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DATA_FILE, "no name");
    if (strcmp(value, "LIST") == 0 || strncmp(value, "LIST ", 5) == 0 || (strchr(value, '%') && strchr(value, ' ')))
        return vit_nrrd_refuse(text, VIT_NRRD_FIELD_DATA_FILE,
                               "data in several files cannot be read; join them into one file first");
    data->file = value;
    return true;
}

bool vit_nrrd_header_parse(const struct vit_nrrd_text *text, struct vit_nrrd_header *header, struct vit_nrrd_data *data)
{
    *header = (struct vit_nrrd_header){0};
    *data = (struct vit_nrrd_data){0};
    return parse_type(text, header) && parse_encoding(text, header) && parse_sizes(text, header, data) &&
           parse_kinds(text, header) && parse_rescale(text, header) && parse_data_place(text, header, data) &&
           vit_nrrd_space_parse(text, header);
}
