#include "store/hdf5_attributes.h"

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "base/error.h"
#include "store/hdf5_handle.h"

namespace prt::hdf5 {

namespace {

using nlohmann::json;

void write_raw(hid_t object, const std::string& name, hid_t type, const void* value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, "making a scalar");
  const Handle attribute(
      H5Acreate2(object, name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
      "making an attribute");
  check(H5Awrite(attribute.id(), type, value), "writing an attribute");
}

/// Terminated by a zero that does not count, so that empty strings and zeros within survive.
Handle string_type(std::size_t length) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "making a string type");
  check(H5Tset_size(type.id(), length + 1), "sizing a string");
  check(H5Tset_cset(type.id(), H5T_CSET_UTF8), "setting UTF-8");
  return type;
}

/// What h5py takes for a bool.
Handle bool_type() {
  Handle type(H5Tenum_create(H5T_STD_I8LE), H5Tclose, "making a bool type");
  const std::int8_t values[] = {0, 1};
  check(H5Tenum_insert(type.id(), "FALSE", &values[0]), "making a bool type");
  check(H5Tenum_insert(type.id(), "TRUE", &values[1]), "making a bool type");
  return type;
}

void write_text(hid_t object, const std::string& name, const std::string& text) {
  write_raw(object, name, string_type(text.size()).id(), text.c_str());
}

/// JSON keeps the sign of the C++ type in memory and forgets it in text, so a number that travelled
/// to another rank comes back as another type: only the value may decide how it is stored.
void write_integer(hid_t object, const std::string& name, const json& value) {
  if (value.is_number_unsigned() || value.get<std::int64_t>() >= 0) {
    const auto v = value.get<std::uint64_t>();
    write_raw(object, name, H5T_STD_U64LE, &v);
  } else {
    const auto v = value.get<std::int64_t>();
    write_raw(object, name, H5T_STD_I64LE, &v);
  }
}

std::string read_text(const Handle& attribute, const Handle& type) {
  if (H5Tis_variable_str(type.id()) != 0) throw UnsoundData("a string attribute is not ours");
  std::string text(H5Tget_size(type.id()), '\0');
  check(H5Aread(attribute.id(), type.id(), text.data()), "reading an attribute");
  text.pop_back();
  return text;
}

template <typename T>
T read_number(const Handle& attribute, hid_t type) {
  T value{};
  check(H5Aread(attribute.id(), type, &value), "reading an attribute");
  return value;
}

json read_value(const Handle& attribute) {
  const Handle space(H5Aget_space(attribute.id()), H5Sclose, "reading a shape");
  if (H5Sget_simple_extent_type(space.id()) != H5S_SCALAR) {
    throw UnsoundData("an attribute is not a scalar");
  }
  const Handle type(H5Aget_type(attribute.id()), H5Tclose, "reading a type");
  const hid_t id = type.id();
  if (H5Tget_class(id) == H5T_STRING) return read_text(attribute, type);
  if (H5Tequal(id, H5T_STD_I64LE) > 0) return read_number<std::int64_t>(attribute, H5T_STD_I64LE);
  if (H5Tequal(id, H5T_STD_U64LE) > 0) return read_number<std::uint64_t>(attribute, H5T_STD_U64LE);
  if (H5Tequal(id, H5T_IEEE_F64LE) > 0) return read_number<double>(attribute, H5T_IEEE_F64LE);
  if (H5Tequal(id, bool_type().id()) > 0) return read_number<std::int8_t>(attribute, id) != 0;
  throw UnsoundData("an attribute has a type that artifacts do not have");
}

herr_t collect_name(hid_t, const char* name, const H5A_info_t*, void* out) {
  static_cast<std::vector<std::string>*>(out)->emplace_back(name);
  return 0;
}

}  // namespace

void write_attribute(hid_t object, const std::string& name, const json& value) {
  if (name.empty() || name.starts_with(kJsonPrefix) || name.find('\0') != std::string::npos) {
    throw std::logic_error("artifact attribute '" + name + "' has a name that cannot be stored");
  }
  if (value.is_boolean()) {
    const std::int8_t v = value.get<bool>() ? 1 : 0;
    write_raw(object, name, bool_type().id(), &v);
  } else if (value.is_number_integer()) {
    write_integer(object, name, value);
  } else if (value.is_number_float()) {
    const auto v = value.get<double>();
    write_raw(object, name, H5T_IEEE_F64LE, &v);
  } else if (value.is_string()) {
    write_text(object, name, value.get_ref<const std::string&>());
  } else {
    write_text(object, kJsonPrefix + name, value.dump());
  }
}

json read_attribute(hid_t object, const std::string& name) {
  const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose,
                         "finding an attribute");
  return read_value(attribute);
}

json read_attributes(hid_t object) {
  std::vector<std::string> names;
  check(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_name, &names),
        "listing attributes");
  json all = json::object();
  for (const std::string& name : names) {
    const json value = read_attribute(object, name);
    if (name.starts_with(kJsonPrefix)) {
      all[name.substr(std::strlen(kJsonPrefix))] = json::parse(value.get<std::string>());
    } else {
      all[name] = value;
    }
  }
  return all;
}

}  // namespace prt::hdf5
