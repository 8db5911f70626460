#include "apps/inspect/watch.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "store/bake_folder.h"

namespace prt {

namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds kLookEvery{500};
/// A running bake writes every second.
constexpr std::chrono::seconds kStandsStill{15};
constexpr std::size_t kBarWidth = 30;

/// Empty object while there is none, or none that can be read.
json read_status(FileSystem& fs, const FileSystem::Path& dir) {
  try {
    const auto bytes = fs.read(dir / kProgressName);
    const json status =
        json::parse(reinterpret_cast<const char*>(bytes.data()),
                    reinterpret_cast<const char*>(bytes.data() + bytes.size()), nullptr, false);
    return status.is_object() ? status : json::object();
  } catch (const FileError&) {
    return json::object();
  }
}

std::string table(const json& status) {
  std::string text;
  for (const json& stage : status.value("stages", json::array())) {
    const auto total = stage.value("total", std::size_t{0});
    const auto done = std::min(total, stage.value("done", std::size_t{0}));
    const std::size_t full = total == 0 ? 0 : kBarWidth * done / total;
    text += fmt::format("  {:<20} [{:=<{}}{:>{}}] {}/{}\n", stage.value("stage", ""), "", full, "",
                        kBarWidth - full, done, total);
  }
  return text;
}

void show(const json& status, std::FILE* out, bool terminal) {
  const std::string line =
      fmt::format("{:8.1f} s  {}\n", status.value("seconds", 0.0), status.value("text", ""));
  // Home and clear: the table stays where it is.
  const std::string text = terminal ? "\033[H\033[2J" + line + table(status) : line;
  std::fputs(text.c_str(), out);
  std::fflush(out);
}

}  // namespace

void watch_bake(FileSystem& fs, const FileSystem::Path& dir, std::FILE* out, bool terminal) {
  static_cast<void>(read_bake(fs, dir));
  json shown;
  auto changed = std::chrono::steady_clock::now();
  bool told = false;
  for (;; std::this_thread::sleep_for(kLookEvery)) {
    const json status = read_status(fs, dir);
    const auto now = std::chrono::steady_clock::now();
    if (status != shown) {
      show(status, out, terminal);
      shown = status;
      changed = now;
      told = false;
    }
    if (status.value("finished", false)) return;
    if (!told && now - changed > kStandsStill) {
      std::fputs("no news: the bake has stopped or hangs; prt_bake goes on with it\n", out);
      std::fflush(out);
      told = true;
    }
  }
}

}  // namespace prt
