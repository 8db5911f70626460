// OpenGL objects that delete themselves, and what is done with them. All of it needs a current
// context. Internal to player/gl.
#pragma once

#include <epoxy/gl.h>

#include <initializer_list>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/types.h"

namespace prt::gl {

/// A GL object's name, which dies with its owner.
class Name {
 public:
  using Remove = void (*)(GLuint);
  Name() = default;
  Name(GLuint id, Remove remove) : id_(id), remove_(remove) {}
  Name(Name&& other) noexcept { *this = std::move(other); }
  Name& operator=(Name&& other) noexcept;
  Name(const Name&) = delete;
  Name& operator=(const Name&) = delete;
  ~Name();
  [[nodiscard]] GLuint id() const { return id_; }

 private:
  GLuint id_ = 0;
  Remove remove_ = nullptr;
};

Name new_buffer();
Name new_texture();
Name new_vertex_array();

/// Memory of the GL that shaders read as a texture of `format`, whose texel has `texel_bytes`, and
/// compute shaders write as storage.
class TexelBuffer {
 public:
  TexelBuffer() = default;
  /// Empty data gives one texel of zeros: GL knows no empty buffer. Throws UserError where this GL
  /// has no room for so many texels.
  TexelBuffer(GLenum format, std::size_t texel_bytes, std::span<const std::byte> data);
  /// Zeros, to be written by shaders.
  TexelBuffer(GLenum format, std::size_t texel_bytes, std::size_t texels);

  [[nodiscard]] std::size_t texels() const { return texels_; }
  void read_at(GLuint texture_unit) const;
  void write_at(GLuint storage_binding) const;
  void clear() const;
  [[nodiscard]] std::vector<float> download(std::size_t floats) const;

 private:
  void create(GLenum format, std::size_t texel_bytes, std::size_t texels, const void* data);
  std::size_t texels_ = 0;
  Name buffer_;
  Name texture_;
};

template <typename T>
TexelBuffer texels(GLenum format, std::size_t texel_bytes, const std::vector<T>& values) {
  return {format, texel_bytes, std::as_bytes(std::span(values))};
}

/// Vectors of four floats, one a texel.
inline TexelBuffer vec4_texels(const std::vector<Eigen::Vector4f>& values) {
  return texels(GL_RGBA32F, 16, values);
}

struct ImageFormat {
  GLenum internal, external, type;
};
inline constexpr ImageFormat kVec4Image{GL_RGBA32F, GL_RGBA, GL_FLOAT};
inline constexpr ImageFormat kHalf4Image{GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT};
inline constexpr ImageFormat kIndex4Image{GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT};
inline constexpr ImageFormat kSrgbImage{GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE};
inline constexpr ImageFormat kDepthImage{GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT};

/// Images of one size that are drawn into together.
class Canvas {
 public:
  Canvas() = default;
  Canvas(int width, int height, std::initializer_list<ImageFormat> colours, bool depth);
  void draw_into() const;  ///< binds it and sets the viewport
  void read_image_at(std::size_t image, GLuint texture_unit) const;
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] GLuint framebuffer() const { return framebuffer_.id(); }

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<Name> images_;
  Name depth_;
  Name framebuffer_;
};

void bind_texture(GLuint unit, GLenum target, GLuint texture);

/// A linked program and its uniforms. Sources are names of embedded shaders, put one after the
/// other behind `defines`, lines of "#define A 1".
class Program {
 public:
  using Sources = std::initializer_list<std::string_view>;
  static Program compute(Sources sources, const std::string& defines = "");
  static Program graphics(Sources vertex, Sources fragment, const std::string& defines = "");

  void use() const;
  void set(const char* name, int value);
  void set(const char* name, unsigned value);
  void set(const char* name, float value);
  void set(const char* name, const Eigen::Vector2f& value);
  void set(const char* name, const Vec3f& value);
  void set(const char* name, const Eigen::Vector4f& value);
  void set(const char* name, const Eigen::Matrix4f& value);

 private:
  explicit Program(Name program) : program_(std::move(program)) {}
  [[nodiscard]] GLint place(const char* name);
  Name program_;
  std::map<std::string, GLint, std::less<>> places_;
};

/// Covers the viewport with one triangle (vertex shader screen.glsl).
class ScreenTriangle {
 public:
  ScreenTriangle();
  void draw() const;

 private:
  Name vertices_;
};

/// Runs `items` invocations in groups of `group` and lets what follows read what they wrote. Throws
/// UserError for more groups than OpenGL runs at once.
void dispatch(std::size_t items, unsigned group);

}  // namespace prt::gl
