#include "player/gl/offscreen.h"

#include <dlfcn.h>
#include <epoxy/egl.h>

#include <array>
#include <vector>

#include "base/error.h"

namespace prt::gl {
namespace {

std::vector<EGLDisplay> displays() {
  std::vector<EGLDisplay> found;
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
    found.push_back(eglGetPlatformDisplayEXT(
        EGL_PLATFORM_SURFACELESS_MESA, reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY), nullptr));
  }
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") &&
      epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration")) {
    std::array<EGLDeviceEXT, 8> devices{};
    EGLint count = 0;
    if (eglQueryDevicesEXT(devices.size(), devices.data(), &count) == EGL_TRUE) {
      for (EGLint i = 0; i < count; ++i) {
        found.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
      }
    }
  }
  found.push_back(eglGetDisplay(EGL_DEFAULT_DISPLAY));
  return found;
}

}  // namespace

struct OffscreenContext::State {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  /// True if a context of this display is now current.
  bool open(EGLDisplay candidate) {
    if (candidate == EGL_NO_DISPLAY) return false;
    if (eglInitialize(candidate, nullptr, nullptr) != EGL_TRUE) return false;
    display = candidate;
    if (eglBindAPI(EGL_OPENGL_API) == EGL_TRUE) {
      const std::array<EGLint, 7> wanted = {EGL_CONTEXT_MAJOR_VERSION,
                                            4,
                                            EGL_CONTEXT_MINOR_VERSION,
                                            3,
                                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                            EGL_NONE};
      context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted.data());
      if (context != EGL_NO_CONTEXT &&
          eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE) {
        return true;
      }
    }
    close();
    return false;
  }

  void close() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    eglTerminate(display);
    display = EGL_NO_DISPLAY;
    context = EGL_NO_CONTEXT;
  }
};

OffscreenContext::OffscreenContext() : state_(std::make_unique<State>()) {
  // epoxy ends the process where the library is missing: ask first.
  if (dlopen("libEGL.so.1", RTLD_LAZY | RTLD_GLOBAL) == nullptr) {
    throw UserError("--backend gl: no EGL on this machine; install libegl1 or use --backend cpu");
  }
  for (EGLDisplay candidate : displays()) {
    if (state_->open(candidate)) return;
  }
  throw UserError(
      "--backend gl: EGL offers no OpenGL 4.3 core here; install libgl1-mesa-dri or a driver, or "
      "use "
      "--backend cpu");
}

OffscreenContext::~OffscreenContext() { state_->close(); }

}  // namespace prt::gl
