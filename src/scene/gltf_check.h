// What a glTF file must satisfy before tinygltf, which checks little, may see it. Internal to
// scene/.
#pragma once

#include "scene/gltf_document.h"

namespace prt::gltf {

/// Types, ranges and references of everything the loader takes from tinygltf's model; bufferViews
/// and accessors are Document's own affair. Throws UserError.
void check_contents(const Document& document);

/// Part of it: transforms, references and the tree of the nodes, and the scenes' lists of roots.
/// No cycle, no node with two parents.
void check_nodes(const Value& root);

/// The member, if it is there, is the index of an element of the file's `array`.
void check_index(const Value& holder, const char* key, const Value& root, const char* array);

/// Member of a value's "extensions", empty where there is none.
std::optional<Value> extension(const Value& value, const char* name);

}  // namespace prt::gltf
