// Thin ownership over HDF5's C handles; private to store/.
#pragma once

#include <hdf5.h>

#include <mutex>
#include <string>
#include <utility>

namespace prt::hdf5 {

/// Held around every use of HDF5: Debian's library may be built without thread safety. Also keeps
/// HDF5 from printing its error stack.
class Session {
 public:
  Session();

 private:
  std::lock_guard<std::mutex> lock_;
};

/// Throws UnsoundData with what was tried and HDF5's innermost reason.
[[noreturn]] void fail(const std::string& what);

/// Passes a non-negative result through, throws UnsoundData otherwise.
template <typename Result>
Result check(Result result, const char* what) {
  if (result < 0) fail(what);
  return result;
}

/// Owns one HDF5 identifier.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close close, const char* what) : id_(check(id, what)), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  [[nodiscard]] hid_t id() const { return id_; }

 private:
  hid_t id_;
  Close close_;
};

/// Property list that leaves no times in the file. `kind` is H5P_FILE_CREATE, H5P_GROUP_CREATE or
/// H5P_DATASET_CREATE.
Handle creation_properties(hid_t kind);

/// The group of that name below `parent`, made if missing.
Handle require_group(hid_t parent, const std::string& name);

}  // namespace prt::hdf5
