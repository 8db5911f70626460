#include "scene/gltf_document.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <optional>

#include "scene/gltf_accessor.h"
#include "scene/gltf_check.h"
#include "scene/gltf_tiny.h"
#include "scene/whole_file.h"

namespace prt::gltf {
namespace fs = std::filesystem;
namespace {

constexpr std::uint32_t kGlbMagic = 0x46546C67;     // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;  // "BIN"

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string percent_decoded(const std::string& uri) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && hex_digit(uri[i + 1]) >= 0 &&
        hex_digit(uri[i + 2]) >= 0) {
      decoded += static_cast<char>(16 * hex_digit(uri[i + 1]) + hex_digit(uri[i + 2]));
      i += 2;
    } else {
      decoded += uri[i];
    }
  }
  return decoded;
}

bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }
/// tinygltf counts the characters of a data URI in int.
constexpr std::size_t kMaxDataUri = std::size_t{1} << 31;

/// RFC 3986: scheme = ALPHA *( ALPHA / DIGIT / "+" / "-" / "." ) ":"
bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  return colon != std::string_view::npos && colon > 0 &&
         std::isalpha(static_cast<unsigned char>(uri[0])) != 0 &&
         std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon), [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '+' || c == '-' ||
                  c == '.';
         });
}

bool is_supported(const std::string& extension) {
  static const std::array<std::string_view, 3> supported = {
      "KHR_mesh_quantization", "KHR_texture_transform", "KHR_lights_punctual"};
  // Material models change how a viewer shades, not where the triangles are.
  return extension.starts_with("KHR_materials_") ||
         std::find(supported.begin(), supported.end(), extension) != supported.end();
}

}  // namespace

Document::Document(const fs::path& file) : file_(file), name_(file.string()) {
  const std::vector<unsigned char> bytes = read_whole_file(file, "scene " + name_, "the file");
  if (bytes.empty()) fail(name_, "the file is empty");
  std::vector<Bytes> buffers = parse(std::as_bytes(std::span(bytes)));
  for (const Bytes& buffer : buffers) buffers_.push_back(std::as_bytes(std::span(buffer)));
  check();
  model_ = tiny_model(*this, std::move(buffers));
  buffers_.clear();
  for (const tinygltf::Buffer& buffer : model_->buffers) {
    buffers_.push_back(std::as_bytes(std::span(buffer.data)));
  }
}

Document::~Document() = default;

void Document::check() const {
  for (std::uint32_t i = 0; i < root().count_of("bufferViews"); ++i) static_cast<void>(view(i));
  for (std::uint32_t i = 0; i < root().count_of("accessors"); ++i) Accessor(*this, i);
  check_contents(*this);
}

std::vector<Document::Bytes> Document::parse(std::span<const std::byte> bytes) {
  const bool is_glb = bytes.size() >= 4 && word_at(bytes, 0) == kGlbMagic;
  if (!is_glb) {
    parse_json(bytes);
    return load_buffers({}, false);
  }
  if (bytes.size() < 20) fail(name_, "the file is truncated: a .glb has at least 20 bytes");
  if (word_at(bytes, 4) != 2) {
    fail(name_, fmt::format("glTF container version {} is not 2", word_at(bytes, 4)));
  }
  const std::size_t length = word_at(bytes, 8);
  if (length != bytes.size()) {
    fail(name_, fmt::format("{}: its header says {} bytes, the file has {}",
                            length > bytes.size() ? "the file is truncated" : "bytes after its end",
                            length, bytes.size()));
  }
  std::span<const std::byte> binary;
  bool has_binary = false;
  for (std::size_t offset = 12, number = 0; offset < length; ++number) {
    if (length - offset < 8) fail(name_, "the header of a chunk is truncated");
    const std::size_t size = word_at(bytes, offset);
    const std::uint32_t type = word_at(bytes, offset + 4);
    if (size > length - offset - 8) fail(name_, fmt::format("chunk {} is truncated", number));
    const std::span<const std::byte> chunk = bytes.subspan(offset + 8, size);
    if ((number == 0) != (type == kJsonChunk)) fail(name_, "the first chunk alone must be JSON");
    if (number == 0) parse_json(chunk);
    if (number == 1 && type == kBinaryChunk) {
      binary = chunk;
      has_binary = true;
    }
    offset += 8 + size;
  }
  return load_buffers(binary, has_binary);
}

void Document::parse_json(std::span<const std::byte> bytes) {
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  try {
    json_ = nlohmann::json::parse(text, text + bytes.size());
  } catch (const nlohmann::json::exception& error) {
    fail(name_, fmt::format("not a glTF file, or a damaged one: {}", error.what()));
  }
  if (!json_.is_object() || !json_.contains("asset")) {
    fail(name_, "not a glTF file: its JSON has no 'asset'");
  }
  check_asset();
  check_extensions();
}

void Document::check_asset() const {
  const Value asset = root()["asset"];
  for (const char* key : {"minVersion", "version"}) {
    const std::optional<Value> version = asset.find(key);
    if (version && !version->text().starts_with("2.")) {
      version->fail(fmt::format("version {} is not 2.x", version->text()));
    }
    if (version) return;
  }
  asset.fail("'version' is missing");
}

void Document::check_extensions() const {
  for (const Value& extension : root().list("extensionsRequired")) {
    if (is_supported(extension.text())) continue;
    extension.fail(
        fmt::format("the file needs the extension {}, which is not supported; export it "
                    "without",
                    extension.text()));
  }
}

std::vector<Document::Bytes> Document::load_buffers(std::span<const std::byte> binary_chunk,
                                                    bool has_chunk) const {
  std::vector<Bytes> buffers;
  for (const Value& buffer : root().list("buffers")) {
    const std::uint64_t length = buffer["byteLength"].whole();
    if (length == 0) buffer["byteLength"].fail("it must be at least 1");
    Bytes bytes;
    if (const std::optional<Value> uri = buffer.find("uri")) {
      bytes = resource(*uri);
    } else if (buffers.empty() && has_chunk) {
      const auto* begin = reinterpret_cast<const unsigned char*>(binary_chunk.data());
      bytes.assign(begin, begin + std::min<std::uint64_t>(binary_chunk.size(), length));
    } else {
      buffer.fail("it has no 'uri', and the file no binary chunk for it");
    }
    if (bytes.size() < length) {
      buffer.fail(fmt::format("{} bytes are promised, {} are there", length, bytes.size()));
    }
    bytes.resize(length);
    buffers.push_back(std::move(bytes));
  }
  return buffers;
}

std::span<const std::byte> Document::view(std::uint32_t index) const {
  const Value view = root().element("bufferViews", index);
  const std::uint32_t buffer = view["buffer"].index(buffers_.size(), "buffers");
  const std::uint64_t offset = view.whole_or("byteOffset", 0);
  const std::uint64_t length = view["byteLength"].whole();
  const std::span<const std::byte> bytes = buffers_[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset) {
    view.fail(fmt::format("bytes {} to {} are out of range: buffer {} has {}", offset,
                          offset + length, buffer, bytes.size()));
  }
  return bytes.subspan(offset, length);
}

std::vector<unsigned char> Document::resource(const Value& uri) const {
  const std::string text = uri.text();
  if (!is_data_uri(text)) {
    return read_whole_file(local_file(uri), "scene " + name_,
                           fmt::format("its resource '{}'", text));
  }
  if (!tinygltf::IsDataURI(text) || text.size() >= kMaxDataUri) {
    uri.fail("a data URI must be in base64, and of a type that glTF names");
  }
  std::vector<unsigned char> bytes;
  std::string type;
  if (!tinygltf::DecodeDataURI(&bytes, type, text, 0, false)) uri.fail("its base64 is damaged");
  return bytes;
}

void Document::check_uri(const Value& uri) const {
  if (!is_data_uri(uri.text())) static_cast<void>(local_file(uri));
}

fs::path Document::local_file(const Value& uri) const {
  const std::string text = uri.text();
  if (has_scheme(text)) {
    uri.fail(fmt::format("'{}': only data URIs and files beside the scene are read", text));
  }
  const std::string decoded = percent_decoded(text);
  const fs::path relative(decoded);
  const bool leaves = decoded.empty() || decoded.find('\0') != std::string::npos ||
                      decoded.find('\\') != std::string::npos || relative.is_absolute();
  if (!leaves) {
    std::error_code error;
    const fs::path folder =
        fs::canonical(file_.has_parent_path() ? file_.parent_path() : ".", error);
    // Follows symbolic links as far as the path exists, so that they cannot lead outside either.
    fs::path target = error ? fs::path() : fs::weakly_canonical(folder / relative, error);
    const fs::path inside = error ? fs::path() : target.lexically_relative(folder);
    if (!inside.empty() && *inside.begin() != ".." && inside != ".") return target;
  }
  uri.fail(fmt::format("'{}' does not lie in the scene's folder", text));
}

}  // namespace prt::gltf
