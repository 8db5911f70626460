#include "package/gltf_writer.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

#include "base/error.h"

namespace prt {
namespace {

constexpr std::uint32_t kGlbMagic = 0x46546C67;     // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;  // "BIN"
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

std::size_t padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

void append_word(std::vector<std::byte>& out, std::size_t word) {
  const auto value = static_cast<std::uint32_t>(word);
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof value);
}

const char* type_name(unsigned components) {
  switch (components) {
    case 1:
      return "SCALAR";
    case 2:
      return "VEC2";
    case 3:
      return "VEC3";
    case 4:
      return "VEC4";
    default:
      throw std::logic_error("no glTF type of that many components");
  }
}

}  // namespace

std::uint32_t GltfWriter::add_view(std::span<const std::byte> bytes, Use use) {
  if (bytes.empty()) throw std::logic_error("glTF has no empty buffer views");
  nlohmann::json view = {
      {"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes.size()}};
  if (use == Use::kVertices) view["target"] = kArrayBuffer;
  if (use == Use::kIndices) view["target"] = kElementArrayBuffer;
  views_.push_back(std::move(view));
  binary_.insert(binary_.end(), bytes.begin(), bytes.end());
  binary_.resize(padded(binary_.size()));
  return static_cast<std::uint32_t>(views_.size() - 1);
}

std::uint32_t GltfWriter::add_accessor(std::span<const std::byte> bytes, int component_type,
                                       std::size_t values, unsigned components, Use use,
                                       bool normalized) {
  if (values % components != 0) throw std::logic_error("accessor: a part of an element is missing");
  nlohmann::json accessor = {{"bufferView", add_view(bytes, use)},
                             {"componentType", component_type},
                             {"count", values / components},
                             {"type", type_name(components)}};
  if (normalized) accessor["normalized"] = true;
  accessors_.push_back(std::move(accessor));
  return static_cast<std::uint32_t>(accessors_.size() - 1);
}

std::uint32_t GltfWriter::add_positions(std::span<const float> xyz) {
  const std::uint32_t index = add(xyz, 3, Use::kVertices);
  nlohmann::json low = nlohmann::json::array();
  nlohmann::json high = nlohmann::json::array();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float minimum = xyz[axis];
    float maximum = xyz[axis];
    for (std::size_t i = axis; i < xyz.size(); i += 3) {
      minimum = std::min(minimum, xyz[i]);
      maximum = std::max(maximum, xyz[i]);
    }
    low.push_back(minimum);
    high.push_back(maximum);
  }
  accessors_[index]["min"] = std::move(low);
  accessors_[index]["max"] = std::move(high);
  return index;
}

std::vector<std::byte> GltfWriter::finish() {
  root["bufferViews"] = views_;
  root["accessors"] = accessors_;
  root["buffers"] = nlohmann::json::array({{{"byteLength", binary_.size()}}});
  // Names may come from anywhere: a byte that is not UTF-8 is replaced, never an exception.
  std::string text = root.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  text.resize(padded(text.size()), ' ');
  const std::size_t size = 12 + 8 + text.size() + 8 + binary_.size();
  if (size > std::numeric_limits<std::uint32_t>::max()) {
    throw UserError("the package would have " + std::to_string(size >> 20) +
                    " MiB, beyond the 4096 of a .glb; use fewer samples or lower ranks");
  }
  std::vector<std::byte> file;
  file.reserve(size);
  for (const std::size_t word : {std::size_t{kGlbMagic}, std::size_t{2}, size}) {
    append_word(file, word);
  }
  append_word(file, text.size());
  append_word(file, kJsonChunk);
  const auto* characters = reinterpret_cast<const std::byte*>(text.data());
  file.insert(file.end(), characters, characters + text.size());
  append_word(file, binary_.size());
  append_word(file, kBinaryChunk);
  file.insert(file.end(), binary_.begin(), binary_.end());
  return file;
}

}  // namespace prt
