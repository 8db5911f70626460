// JSON values as HDF5 attributes, and back without loss; private to store/.
#pragma once

#include <hdf5.h>

#include <nlohmann/json.hpp>
#include <string>

namespace prt::hdf5 {

/// Nested values and null are JSON text under this prefix and the name.
inline constexpr const char* kJsonPrefix = "json:";

/// Call within a Session. Throws std::logic_error for a name that is empty or starts with
/// kJsonPrefix.
void write_attribute(hid_t object, const std::string& name, const nlohmann::json& value);

/// Throws UnsoundData if it is missing or of a type that write_attribute does not make.
nlohmann::json read_attribute(hid_t object, const std::string& name);

/// All attributes as one JSON object, prefixes taken off.
nlohmann::json read_attributes(hid_t object);

}  // namespace prt::hdf5
