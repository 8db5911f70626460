// Hands a checked glTF file to tinygltf. Internal to scene/.
#pragma once

#include <memory>
#include <vector>

#include "scene/gltf_document.h"

namespace prt::gltf {

/// tinygltf's model of a document that has passed check_contents(). The buffers' bytes move into
/// it, trimmed to their byteLength. It holds the encoded bytes of the images that materials use as
/// base colour (Image::as_is); other images stay empty. tinygltf itself opens no file: it sees
/// extras and foreign extensions as little as URIs. Throws UserError with what tinygltf objects to.
std::unique_ptr<tinygltf::Model> tiny_model(const Document& document,
                                            std::vector<std::vector<unsigned char>> buffers);

}  // namespace prt::gltf
