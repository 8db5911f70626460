#include "store/hdf5_memory.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>

#include "base/error.h"

namespace prt::hdf5 {

namespace {

// Place of the end-of-file address in a superblock of version 2, which format 1.8 has (HDF5 File
// Format Specification, II.A).
constexpr std::size_t kEndOfFileOffset = 28;
constexpr std::size_t kSuperblockBytes = 48;

// HDF5 opens a file of the given name, if there is one, even where all is in memory: this one can
// exist nowhere.
constexpr const char* kNoFile = "/dev/null/memory";

herr_t keep(void*, H5FD_file_image_op_t, void*) { return 0; }
void* share(void* data) { return data; }
herr_t drop_share(void*) { return 0; }

void* lend(std::size_t, H5FD_file_image_op_t, void* memory) { return memory; }
void* lend_copy(void* to, const void*, std::size_t, H5FD_file_image_op_t, void*) { return to; }
void* refuse_resize(void*, std::size_t, H5FD_file_image_op_t, void*) { return nullptr; }

Handle access_properties(std::size_t increment, H5FD_file_image_callbacks_t callbacks) {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "making a property list");
  check(H5Pset_fapl_core(access.id(), increment, false), "choosing memory");
  check(H5Pset_libver_bounds(access.id(), H5F_LIBVER_V18, H5F_LIBVER_V18), "fixing the format");
  check(H5Pset_file_image_callbacks(access.id(), &callbacks), "lending memory");
  return access;
}

Handle open_borrowed(std::span<const std::byte> bytes) {
  // Never written to: the file is opened for reading only.
  void* memory = const_cast<std::byte*>(bytes.data());
  const Handle access =
      access_properties(1 << 16, {lend, lend_copy, refuse_resize, keep, share, drop_share, memory});
  check(H5Pset_file_image(access.id(), memory, bytes.size()), "lending memory");
  return {H5Fopen(kNoFile, H5F_ACC_RDONLY, access.id()), H5Fclose, "opening a file"};
}

}  // namespace

MemoryFile::MemoryFile(std::size_t expected_bytes) {
  const Handle access =
      access_properties(std::max<std::size_t>(expected_bytes, 1 << 14),
                        {nullptr, nullptr, resize, keep, share, drop_share, this});
  const Handle creation = creation_properties(H5P_FILE_CREATE);
  file_.emplace(H5Fcreate(kNoFile, H5F_ACC_TRUNC, creation.id(), access.id()), H5Fclose,
                "making a file in memory");
}

void* MemoryFile::resize(void*, std::size_t size, H5FD_file_image_op_t, void* self) {
  auto& bytes = static_cast<MemoryFile*>(self)->bytes_;
  try {
    bytes.resize(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
  return bytes.data();
}

std::vector<std::byte> MemoryFile::close() {
  if (H5Fget_obj_count(file_->id(), H5F_OBJ_ALL) != 1) fail("closing a file that is in use");
  file_.reset();
  std::uint64_t size = 0;
  if (bytes_.size() >= kSuperblockBytes) {
    std::memcpy(&size, bytes_.data() + kEndOfFileOffset, sizeof size);
  }
  if (size < kSuperblockBytes || size > bytes_.size()) fail("closing a file");
  bytes_.resize(size);
  return std::move(bytes_);
}

BorrowedFile::BorrowedFile(std::span<const std::byte> bytes) : file_(open_borrowed(bytes)) {}

}  // namespace prt::hdf5
