#version 100
// What differs between GLSL ES 3.00 and 1.00; every stage is written in the subset behind these names.
#ifdef GL_OES_texture_3D
#extension GL_OES_texture_3D : enable
#define VIT_SAMPLER_3D sampler3D
#define VIT_TEXTURE_3D texture3D
#endif
#ifdef GL_FRAGMENT_PRECISION_HIGH
precision highp float;
precision highp sampler2D;
#else
precision mediump float;
#endif
#ifdef VIT_VERTEX
#define VIT_ATTRIBUTE attribute
#endif
#define VIT_VARYING varying
#define VIT_TEXTURE_2D texture2D
#ifdef VIT_FRAGMENT
#define VIT_COLOR gl_FragColor
#endif
