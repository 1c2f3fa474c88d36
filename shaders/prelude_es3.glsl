#version 300 es
// What differs between GLSL ES 3.00 and 1.00; every stage is written in the subset behind these names.
precision highp float;
precision highp int;
precision highp sampler2D; // lowp unless said: drivers then deliver half floats
precision highp sampler3D;
precision highp sampler2DArray;
#define VIT_ES3 1
#ifdef VIT_VERTEX
#define VIT_ATTRIBUTE in
#define VIT_VARYING out
#else
#define VIT_VARYING in
out vec4 vit_color;
#define VIT_COLOR vit_color
#endif
#define VIT_SAMPLER_3D sampler3D
#define VIT_TEXTURE_3D texture
#define VIT_TEXTURE_2D texture
