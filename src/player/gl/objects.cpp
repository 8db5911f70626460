#include "player/gl/objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "player/gl/shader_source.h"

namespace prt::gl {
namespace {

/// Work groups of one dispatch that every OpenGL allows.
constexpr std::size_t kMostGroups = 65535;

void delete_framebuffer(GLuint id) { glDeleteFramebuffers(1, &id); }
void delete_shader(GLuint id) { glDeleteShader(id); }
void delete_program(GLuint id) { glDeleteProgram(id); }

Name compile(GLenum stage, Program::Sources sources, const std::string& defines) {
  std::string text = "#version 430 core\n" + defines + "\n";
  for (const std::string_view name : sources) {
    const std::string_view source = shader_source(name);
    if (source.empty()) throw std::logic_error(fmt::format("no shader {}", name));
    text += source;
  }
  Name shader(glCreateShader(stage), delete_shader);
  const char* lines = text.c_str();
  glShaderSource(shader.id(), 1, &lines, nullptr);
  glCompileShader(shader.id());
  GLint done = GL_FALSE;
  glGetShaderiv(shader.id(), GL_COMPILE_STATUS, &done);
  if (done == GL_TRUE) return shader;
  std::array<char, 2000> log{};
  glGetShaderInfoLog(shader.id(), log.size(), nullptr, log.data());
  throw std::runtime_error(fmt::format("shader {}: {}", *(sources.end() - 1), log.data()));
}

Name link(std::initializer_list<GLuint> shaders) {
  Name program(glCreateProgram(), delete_program);
  for (const GLuint shader : shaders) glAttachShader(program.id(), shader);
  glLinkProgram(program.id());
  GLint done = GL_FALSE;
  glGetProgramiv(program.id(), GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return program;
  std::array<char, 2000> log{};
  glGetProgramInfoLog(program.id(), log.size(), nullptr, log.data());
  throw std::runtime_error(fmt::format("shaders do not link: {}", log.data()));
}

Name make_image(int width, int height, const ImageFormat& format) {
  Name image = new_texture();
  glBindTexture(GL_TEXTURE_2D, image.id());
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format.internal), width, height, 0,
               format.external, format.type, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return image;
}

}  // namespace

Name new_buffer() {
  GLuint id = 0;
  glGenBuffers(1, &id);
  return {id, [](GLuint old) { glDeleteBuffers(1, &old); }};
}

Name new_texture() {
  GLuint id = 0;
  glGenTextures(1, &id);
  return {id, [](GLuint old) { glDeleteTextures(1, &old); }};
}

Name new_vertex_array() {
  GLuint id = 0;
  glGenVertexArrays(1, &id);
  return {id, [](GLuint old) { glDeleteVertexArrays(1, &old); }};
}

Name& Name::operator=(Name&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(remove_, other.remove_);
  return *this;
}

Name::~Name() {
  if (id_ != 0) remove_(id_);
}

TexelBuffer::TexelBuffer(GLenum format, std::size_t texel_bytes, std::span<const std::byte> data) {
  const std::size_t texels =
      std::max<std::size_t>(1, (data.size() + texel_bytes - 1) / texel_bytes);
  if (data.size() == texels * texel_bytes) {
    create(format, texel_bytes, texels, data.data());
    return;
  }
  std::vector<std::byte> padded(data.begin(), data.end());
  padded.resize(texels * texel_bytes);
  create(format, texel_bytes, texels, padded.data());
}

TexelBuffer::TexelBuffer(GLenum format, std::size_t texel_bytes, std::size_t texels) {
  create(format, texel_bytes, std::max<std::size_t>(1, texels), nullptr);
}

void TexelBuffer::create(GLenum format, std::size_t texel_bytes, std::size_t texels,
                         const void* data) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  if (texels > static_cast<std::size_t>(most)) {
    throw UserError(
        fmt::format("this package needs a buffer of {} texels, and this OpenGL has room "
                    "for {}; use --backend cpu",
                    texels, most));
  }
  texels_ = texels;
  buffer_ = new_buffer();
  glBindBuffer(GL_TEXTURE_BUFFER, buffer_.id());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(texels * texel_bytes), data,
               data != nullptr ? GL_STATIC_DRAW : GL_DYNAMIC_COPY);
  if (data == nullptr) clear();
  texture_ = new_texture();
  glBindTexture(GL_TEXTURE_BUFFER, texture_.id());
  glTexBuffer(GL_TEXTURE_BUFFER, format, buffer_.id());
}

void TexelBuffer::clear() const {
  glBindBuffer(GL_TEXTURE_BUFFER, buffer_.id());
  glClearBufferData(GL_TEXTURE_BUFFER, GL_R32F, GL_RED, GL_FLOAT, nullptr);
}

void TexelBuffer::read_at(GLuint texture_unit) const {
  bind_texture(texture_unit, GL_TEXTURE_BUFFER, texture_.id());
}

void TexelBuffer::write_at(GLuint storage_binding) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, storage_binding, buffer_.id());
}

std::vector<float> TexelBuffer::download(std::size_t floats) const {
  std::vector<float> values(floats);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glBindBuffer(GL_TEXTURE_BUFFER, buffer_.id());
  glGetBufferSubData(GL_TEXTURE_BUFFER, 0, static_cast<GLsizeiptr>(floats * sizeof(float)),
                     values.data());
  return values;
}

Canvas::Canvas(int width, int height, std::initializer_list<ImageFormat> colours, bool depth)
    : width_(width), height_(height) {
  GLuint id = 0;
  glGenFramebuffers(1, &id);
  framebuffer_ = Name(id, delete_framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, id);
  std::vector<GLenum> attachments;
  for (const ImageFormat& format : colours) {
    attachments.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(images_.size()));
    images_.push_back(make_image(width, height, format));
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachments.back(), GL_TEXTURE_2D, images_.back().id(),
                           0);
  }
  if (depth) {
    depth_ = make_image(width, height, kDepthImage);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_.id(), 0);
  }
  glDrawBuffers(static_cast<GLsizei>(attachments.size()), attachments.data());
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw UserError(
        fmt::format("this OpenGL cannot draw pictures of {}x{} pixels; make --size "
                    "smaller or use --backend cpu",
                    width, height));
  }
}

void Canvas::draw_into() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  glViewport(0, 0, width_, height_);
}

void Canvas::read_image_at(std::size_t image, GLuint texture_unit) const {
  bind_texture(texture_unit, GL_TEXTURE_2D, images_.at(image).id());
}

void bind_texture(GLuint unit, GLenum target, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(target, texture);
}

Program Program::compute(Sources sources, const std::string& defines) {
  const Name shader = compile(GL_COMPUTE_SHADER, sources, defines);
  return Program(link({shader.id()}));
}

Program Program::graphics(Sources vertex, Sources fragment, const std::string& defines) {
  const Name first = compile(GL_VERTEX_SHADER, vertex, defines);
  const Name second = compile(GL_FRAGMENT_SHADER, fragment, defines);
  return Program(link({first.id(), second.id()}));
}

void Program::use() const { glUseProgram(program_.id()); }

GLint Program::place(const char* name) {
  const auto known = places_.find(name);
  if (known != places_.end()) return known->second;
  return places_.emplace(name, glGetUniformLocation(program_.id(), name)).first->second;
}

void Program::set(const char* name, int value) { glUniform1i(place(name), value); }
void Program::set(const char* name, unsigned value) { glUniform1ui(place(name), value); }
void Program::set(const char* name, float value) { glUniform1f(place(name), value); }
void Program::set(const char* name, const Eigen::Vector2f& value) {
  glUniform2fv(place(name), 1, value.data());
}
void Program::set(const char* name, const Vec3f& value) {
  glUniform3fv(place(name), 1, value.data());
}
void Program::set(const char* name, const Eigen::Vector4f& value) {
  glUniform4fv(place(name), 1, value.data());
}
void Program::set(const char* name, const Eigen::Matrix4f& value) {
  glUniformMatrix4fv(place(name), 1, GL_FALSE, value.data());
}

ScreenTriangle::ScreenTriangle() : vertices_(new_vertex_array()) {}

void ScreenTriangle::draw() const {
  glDisable(GL_DEPTH_TEST);
  glBindVertexArray(vertices_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void dispatch(std::size_t items, unsigned group) {
  if (items == 0) return;
  const std::size_t groups = (items + group - 1) / group;
  if (groups > kMostGroups) {
    throw UserError(
        fmt::format("this package has work for {} groups of OpenGL invocations, and {} "
                    "are the most; use --backend cpu",
                    groups, kMostGroups));
  }
  glDispatchCompute(static_cast<GLuint>(groups), 1, 1);
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

}  // namespace prt::gl
