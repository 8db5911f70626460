#include "unit/scene/gltf_writer.h"

#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace prt::testing {
namespace {

void append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data),
                                             static_cast<std::size_t>(size));
}

}  // namespace

std::string png(int width, int height, const std::vector<std::uint8_t>& rgba) {
  std::string bytes;
  stbi_write_png_to_func(append, &bytes, width, height, 4, rgba.data(), 4 * width);
  return bytes;
}

std::string jpeg(int width, int height, const std::vector<std::uint8_t>& rgba) {
  std::string bytes;
  stbi_write_jpg_to_func(append, &bytes, width, height, 4, rgba.data(), 95);
  return bytes;
}

void set_texture(GltfWriter& writer, const std::string& image) {
  const std::size_t view = writer.add_view(image);
  const bool is_png = image.starts_with("\x89PNG");
  writer.append("images",
                {{"bufferView", view}, {"mimeType", is_png ? "image/png" : "image/jpeg"}});
  const std::size_t texture =
      writer.append("textures", {{"source", writer.json["images"].size() - 1}});
  if (!writer.json.contains("materials")) {
    writer.append("materials", GltfWriter::Json::object());
    writer.json["meshes"][0]["primitives"][0]["material"] = 0;
  }
  writer.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = texture;
}

}  // namespace prt::testing
