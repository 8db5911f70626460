#include "store/hdf5_handle.h"

#include "base/error.h"

namespace prt::hdf5 {

namespace {

std::mutex& library_mutex() {
  static std::mutex mutex;
  return mutex;
}

herr_t keep_innermost(unsigned n, const H5E_error2_t* error, void* out) {
  if (n == 0 && error->desc != nullptr) *static_cast<std::string*>(out) = error->desc;
  return 0;
}

}  // namespace

Session::Session() : lock_(library_mutex()) {
  // The error stack belongs to a thread where HDF5 is thread-safe, so this is not done once.
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

void fail(const std::string& what) {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &reason);
  throw UnsoundData("HDF5: " + what + " failed" + (reason.empty() ? "" : ": " + reason));
}

Handle creation_properties(hid_t kind) {
  Handle properties(H5Pcreate(kind), H5Pclose, "making a property list");
  check(H5Pset_obj_track_times(properties.id(), false), "switching times off");
  return properties;
}

Handle require_group(hid_t parent, const std::string& name) {
  const htri_t exists = check(H5Lexists(parent, name.c_str(), H5P_DEFAULT), "finding a group");
  if (exists > 0) return {H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose, "opening a group"};
  const Handle properties = creation_properties(H5P_GROUP_CREATE);
  return {H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, properties.id(), H5P_DEFAULT), H5Gclose,
          "making a group"};
}

}  // namespace prt::hdf5
