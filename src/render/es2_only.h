/* Every entry point that OpenGL ES 3.0 has and ES 2 has not may not be named after this header: drivers keep them in ES
 * 2 contexts too. What needs one goes through vit_gl_es3_* (gl.h), which refuses there. The names are those of Khronos'
 * GLES3/gl3.h that GLES2/gl2.h lacks. */
#ifndef VITRINE_RENDER_ES2_ONLY_H
#define VITRINE_RENDER_ES2_ONLY_H

#include <GLES3/gl3.h>

#include <GLES2/gl2ext.h>

/* clang-format off */
#pragma GCC poison glBeginQuery glBeginTransformFeedback glBindBufferBase glBindBufferRange glBindSampler
#pragma GCC poison glBindTransformFeedback glBindVertexArray glBlitFramebuffer glClearBufferfi glClearBufferfv
#pragma GCC poison glClearBufferiv glClearBufferuiv glClientWaitSync glCompressedTexImage3D
#pragma GCC poison glCompressedTexSubImage3D glCopyBufferSubData glCopyTexSubImage3D glDeleteQueries
#pragma GCC poison glDeleteSamplers glDeleteSync glDeleteTransformFeedbacks glDeleteVertexArrays
#pragma GCC poison glDrawArraysInstanced glDrawBuffers glDrawElementsInstanced glDrawRangeElements glEndQuery
#pragma GCC poison glEndTransformFeedback glFenceSync glFlushMappedBufferRange glFramebufferTextureLayer
#pragma GCC poison glGenQueries glGenSamplers glGenTransformFeedbacks glGenVertexArrays glGetActiveUniformBlockName
#pragma GCC poison glGetActiveUniformBlockiv glGetActiveUniformsiv glGetBufferParameteri64v glGetBufferPointerv
#pragma GCC poison glGetFragDataLocation glGetInteger64i glGetInteger64v glGetIntegeri glGetInternalformativ
#pragma GCC poison glGetProgramBinary glGetQueryObjectuiv glGetQueryiv glGetSamplerParameterfv
#pragma GCC poison glGetSamplerParameteriv glGetStringi glGetSynciv glGetTransformFeedbackVarying
#pragma GCC poison glGetUniformBlockIndex glGetUniformIndices glGetUniformuiv glGetVertexAttribIiv
#pragma GCC poison glGetVertexAttribIuiv glInvalidateFramebuffer glInvalidateSubFramebuffer glIsQuery glIsSampler
#pragma GCC poison glIsSync glIsTransformFeedback glIsVertexArray glMapBufferRange glPauseTransformFeedback
#pragma GCC poison glProgramBinary glProgramParameteri glReadBuffer glRenderbufferStorageMultisample
#pragma GCC poison glResumeTransformFeedback glSamplerParameterf glSamplerParameterfv glSamplerParameteri
#pragma GCC poison glSamplerParameteriv glTexImage3D glTexStorage2D glTexStorage3D glTexSubImage3D
#pragma GCC poison glTransformFeedbackVaryings glUniform1ui glUniform1uiv glUniform2ui glUniform2uiv glUniform3ui
#pragma GCC poison glUniform3uiv glUniform4ui glUniform4uiv glUniformBlockBinding glUniformMatrix2x3fv
#pragma GCC poison glUniformMatrix2x4fv glUniformMatrix3x2fv glUniformMatrix3x4fv glUniformMatrix4x2fv
#pragma GCC poison glUniformMatrix4x3fv glUnmapBuffer glVertexAttribDivisor glVertexAttribI4i glVertexAttribI4iv
#pragma GCC poison glVertexAttribI4ui glVertexAttribI4uiv glVertexAttribIPointer glWaitSync
/* clang-format on */

#endif
