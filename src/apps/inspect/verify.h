// prt_inspect --verify: is every artifact of a bake what its manifest says?
#pragma once

#include <string>
#include <vector>

#include "apps/inspect/bake_reader.h"

namespace prt {

struct Verification {
  struct Unsound {
    std::string task;
    std::string reason;  ///< names the file
  };
  std::size_t checked = 0;
  std::size_t not_kept = 0;  ///< let go by a finished bake with store.keep: needed
  std::vector<Unsound> unsound;
};

/// Hashes each artifact's file again, compares it with the manifest and reads all its datasets
/// through HDF5; the index, too. A missing artifact is unsound unless a sound index of a finished
/// bake leaves it out.
Verification verify_bake(const BakeReader& bake);
std::string to_text(const Verification& verification);
nlohmann::json to_json(const Verification& verification);

}  // namespace prt
