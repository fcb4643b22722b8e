// SPDX-License-Identifier: Zlib
#pragma once

#include <GL/glcorearb.h>

#include <string>
#include <string_view>

namespace limber::render {

class GlContext;

/// All OpenGL functions that this library calls: X(name without "gl", name in the function's type).
#define LIMBER_GL_FUNCTIONS(X)                                \
  X(ActiveTexture, ACTIVETEXTURE)                             \
  X(AttachShader, ATTACHSHADER)                               \
  X(BindBuffer, BINDBUFFER)                                   \
  X(BindBufferBase, BINDBUFFERBASE)                           \
  X(BindBufferRange, BINDBUFFERRANGE)                         \
  X(BindFramebuffer, BINDFRAMEBUFFER)                         \
  X(BindSampler, BINDSAMPLER)                                 \
  X(BindTexture, BINDTEXTURE)                                 \
  X(BindTextureUnit, BINDTEXTUREUNIT)                         \
  X(BindVertexArray, BINDVERTEXARRAY)                         \
  X(BlendEquationSeparatei, BLENDEQUATIONSEPARATEI)           \
  X(BlendFuncSeparatei, BLENDFUNCSEPARATEI)                   \
  X(BlitNamedFramebuffer, BLITNAMEDFRAMEBUFFER)               \
  X(CheckNamedFramebufferStatus, CHECKNAMEDFRAMEBUFFERSTATUS) \
  X(ClearNamedFramebufferfv, CLEARNAMEDFRAMEBUFFERFV)         \
  X(ClientWaitSync, CLIENTWAITSYNC)                           \
  X(ClipControl, CLIPCONTROL)                                 \
  X(ColorMaski, COLORMASKI)                                   \
  X(CompileShader, COMPILESHADER)                             \
  X(CopyImageSubData, COPYIMAGESUBDATA)                       \
  X(CreateBuffers, CREATEBUFFERS)                             \
  X(CreateFramebuffers, CREATEFRAMEBUFFERS)                   \
  X(CreateProgram, CREATEPROGRAM)                             \
  X(CreateShader, CREATESHADER)                               \
  X(CreateTextures, CREATETEXTURES)                           \
  X(CreateVertexArrays, CREATEVERTEXARRAYS)                   \
  X(CullFace, CULLFACE)                                       \
  X(DebugMessageCallback, DEBUGMESSAGECALLBACK)               \
  X(DeleteBuffers, DELETEBUFFERS)                             \
  X(DeleteFramebuffers, DELETEFRAMEBUFFERS)                   \
  X(DeleteProgram, DELETEPROGRAM)                             \
  X(DeleteShader, DELETESHADER)                               \
  X(DeleteSync, DELETESYNC)                                   \
  X(DeleteTextures, DELETETEXTURES)                           \
  X(DeleteVertexArrays, DELETEVERTEXARRAYS)                   \
  X(DepthFunc, DEPTHFUNC)                                     \
  X(DepthMask, DEPTHMASK)                                     \
  X(DepthRangeIndexed, DEPTHRANGEINDEXED)                     \
  X(Disable, DISABLE)                                         \
  X(Disablei, DISABLEI)                                       \
  X(DispatchCompute, DISPATCHCOMPUTE)                         \
  X(DrawArraysInstanced, DRAWARRAYSINSTANCED)                 \
  X(DrawElementsInstanced, DRAWELEMENTSINSTANCED)             \
  X(Enable, ENABLE)                                           \
  X(EnableVertexArrayAttrib, ENABLEVERTEXARRAYATTRIB)         \
  X(Enablei, ENABLEI)                                         \
  X(FenceSync, FENCESYNC)                                     \
  X(Finish, FINISH)                                           \
  X(Flush, FLUSH)                                             \
  X(FrontFace, FRONTFACE)                                     \
  X(GenerateTextureMipmap, GENERATETEXTUREMIPMAP)             \
  X(GetError, GETERROR)                                       \
  X(GetFloati_v, GETFLOATI_V)                                 \
  X(GetFloatv, GETFLOATV)                                     \
  X(GetInteger64i_v, GETINTEGER64I_V)                         \
  X(GetInteger64v, GETINTEGER64V)                             \
  X(GetIntegeri_v, GETINTEGERI_V)                             \
  X(GetIntegerv, GETINTEGERV)                                 \
  X(GetNamedBufferSubData, GETNAMEDBUFFERSUBDATA)             \
  X(GetProgramInfoLog, GETPROGRAMINFOLOG)                     \
  X(GetProgramiv, GETPROGRAMIV)                               \
  X(GetShaderInfoLog, GETSHADERINFOLOG)                       \
  X(GetShaderiv, GETSHADERIV)                                 \
  X(GetString, GETSTRING)                                     \
  X(GetStringi, GETSTRINGI)                                   \
  X(GetUniformLocation, GETUNIFORMLOCATION)                   \
  X(IsEnabled, ISENABLED)                                     \
  X(IsEnabledi, ISENABLEDI)                                   \
  X(IsFramebuffer, ISFRAMEBUFFER)                             \
  X(LinkProgram, LINKPROGRAM)                                 \
  X(MapNamedBufferRange, MAPNAMEDBUFFERRANGE)                 \
  X(MemoryBarrier, MEMORYBARRIER)                             \
  X(NamedBufferStorage, NAMEDBUFFERSTORAGE)                   \
  X(NamedBufferSubData, NAMEDBUFFERSUBDATA)                   \
  X(NamedFramebufferDrawBuffer, NAMEDFRAMEBUFFERDRAWBUFFER)   \
  X(NamedFramebufferReadBuffer, NAMEDFRAMEBUFFERREADBUFFER)   \
  X(NamedFramebufferTexture, NAMEDFRAMEBUFFERTEXTURE)         \
  X(PauseTransformFeedback, PAUSETRANSFORMFEEDBACK)           \
  X(PixelStorei, PIXELSTOREI)                                 \
  X(PolygonMode, POLYGONMODE)                                 \
  X(ProgramUniform1f, PROGRAMUNIFORM1F)                       \
  X(ProgramUniform1ui, PROGRAMUNIFORM1UI)                     \
  X(ProgramUniform4f, PROGRAMUNIFORM4F)                       \
  X(ProvokingVertex, PROVOKINGVERTEX)                         \
  X(ReadPixels, READPIXELS)                                   \
  X(ResumeTransformFeedback, RESUMETRANSFORMFEEDBACK)         \
  X(ShaderSource, SHADERSOURCE)                               \
  X(TextureParameterfv, TEXTUREPARAMETERFV)                   \
  X(TextureParameteri, TEXTUREPARAMETERI)                     \
  X(TextureStorage2D, TEXTURESTORAGE2D)                       \
  X(TextureStorage2DMultisample, TEXTURESTORAGE2DMULTISAMPLE) \
  X(TextureStorage3D, TEXTURESTORAGE3D)                       \
  X(TextureSubImage3D, TEXTURESUBIMAGE3D)                     \
  X(UseProgram, USEPROGRAM)                                   \
  X(VertexArrayAttribBinding, VERTEXARRAYATTRIBBINDING)       \
  X(VertexArrayAttribFormat, VERTEXARRAYATTRIBFORMAT)         \
  X(VertexArrayAttribIFormat, VERTEXARRAYATTRIBIFORMAT)       \
  X(VertexArrayElementBuffer, VERTEXARRAYELEMENTBUFFER)       \
  X(VertexArrayVertexBuffer, VERTEXARRAYVERTEXBUFFER)         \
  X(ViewportIndexedf, VIEWPORTINDEXEDF)                       \
  X(ViewportIndexedfv, VIEWPORTINDEXEDFV)

/// The functions of one context. They are members, not globals: global symbols with OpenGL's names could
/// replace those inside the driver.
struct Gl {
#define LIMBER_GL_MEMBER(name, TYPE) PFNGL##TYPE##PROC name = nullptr;
  LIMBER_GL_FUNCTIONS(LIMBER_GL_MEMBER)
#undef LIMBER_GL_MEMBER
};

/// Loads all functions through a context that is current on this thread.
/// Throws std::runtime_error if a function is missing, if the version is below 4.5, or if the driver lacks a
/// limit or an extension that the library needs. The text names the driver and the missing item.
Gl loadGl(const GlContext& context);

/// "vendor / renderer / version" of the current context, for messages.
std::string describeDriver(const Gl& gl);

/// Returns true if the current context draws on the CPU (Mesa's llvmpipe and softpipe, SwiftShader, ...).
bool isSoftwareRasteriser(const Gl& gl);
/// The same for the text of GL_RENDERER.
bool isSoftwareRasteriser(std::string_view renderer);

/// Throws std::runtime_error with `where` if any OpenGL error is pending.
void checkGlErrors(const Gl& gl, const char* where);
/// Clears the pending errors, so that they are not attributed to the next call. Returns their names.
std::string takeGlErrors(const Gl& gl);

}  // namespace limber::render
