// Materials and base-colour textures of a glTF file. Internal to scene/.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "scene/gltf_document.h"
#include "scene/scene.h"

namespace prt::gltf {

/// Where the texture coordinates of a material come from.
struct TextureCoordinates {
  std::uint32_t set = 0;                                    ///< n of TEXCOORD_n
  Eigen::Affine2d transform = Eigen::Affine2d::Identity();  ///< KHR_texture_transform
};

/// Fills scene.materials and scene.textures (only those used as base colour), counts clamped
/// albedos and notes what is ignored. The result has one element per material, in the file's order.
std::vector<TextureCoordinates> load_materials(const Document& document, Scene& scene);

/// Decodes PNG or JPEG bytes; fills width, height, rgba, encoded and mime_type. `where` is whom to
/// blame.
void decode_image(const std::vector<unsigned char>& encoded, const Value& where, Texture& texture);

}  // namespace prt::gltf
