#include "apps/inspect/verify.h"

#include <fmt/format.h>

#include <optional>
#include <set>

#include "store/index.h"

namespace prt {

namespace {

/// KEYs of the artifacts that a finished bake keeps; nothing where it did not say.
std::optional<std::set<Digest>> kept_keys(const BakeReader& bake, Verification& result) {
  const auto index = bake.path() / kIndexName;
  if (!bake.file_system().size(index)) return std::nullopt;
  try {
    ++result.checked;
    return read_index(bake.file_system(), bake.path());
  } catch (const UnsoundData& error) {
    result.unsound.push_back({"index", index.string() + ": " + error.what()});
  }
  return std::nullopt;
}

}  // namespace

Verification verify_bake(const BakeReader& bake) {
  Verification result;
  const auto kept = kept_keys(bake, result);
  for (const ManifestEntry& entry : bake.manifest().entries) {
    if (kept && !kept->contains(entry.key) && bake.is_missing(entry)) {
      ++result.not_kept;
      continue;
    }
    ++result.checked;
    try {
      (void)bake.store().read(entry.kind, entry.key, entry.content);
    } catch (const UnsoundData& error) {
      result.unsound.push_back({entry.task, error.what()});
    }
  }
  return result;
}

std::string to_text(const Verification& verification) {
  std::string out;
  for (const auto& unsound : verification.unsound) {
    out += fmt::format("unsound: {}: {}\n", unsound.task, unsound.reason);
  }
  out += fmt::format("{} file(s) checked, {} unsound", verification.checked,
                     verification.unsound.size());
  if (verification.not_kept > 0) out += fmt::format(", {} not kept", verification.not_kept);
  out += verification.unsound.empty() ? "\n" : "; prt_bake makes unsound ones again\n";
  return out;
}

nlohmann::json to_json(const Verification& verification) {
  nlohmann::json unsound = nlohmann::json::array();
  for (const auto& u : verification.unsound) {
    unsound.push_back({{"task", u.task}, {"reason", u.reason}});
  }
  return {
      {"checked", verification.checked}, {"not_kept", verification.not_kept}, {"unsound", unsound}};
}

}  // namespace prt
