// HDF5 files in memory, without copies: HDF5's core driver works on memory of ours. Private to
// store/; use within a Session.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "store/hdf5_handle.h"

namespace prt::hdf5 {

/// A new file, in the format of HDF5 1.8.
class MemoryFile {
 public:
  /// `expected_bytes`: a bound on the file's size, so that its memory need not grow.
  explicit MemoryFile(std::size_t expected_bytes);
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] hid_t id() const { return file_->id(); }
  /// Closes the file and gives its bytes. (H5Fget_file_image of HDF5 1.10 will not do: it clears
  /// flags in a superblock without mending its checksum, and HDF5 refuses the result.) All handles
  /// into the file must be closed.
  std::vector<std::byte> close();

 private:
  static void* resize(void* memory, std::size_t size, H5FD_file_image_op_t, void* self);

  std::vector<std::byte> bytes_;
  std::optional<Handle> file_;
};

/// A file to read, in memory that must outlive it.
class BorrowedFile {
 public:
  explicit BorrowedFile(std::span<const std::byte> bytes);
  [[nodiscard]] hid_t id() const { return file_.id(); }

 private:
  Handle file_;
};

}  // namespace prt::hdf5
