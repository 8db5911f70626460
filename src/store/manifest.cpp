#include "store/manifest.h"

#include <cerrno>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "base/log.h"

namespace prt {

namespace {

using nlohmann::json;

constexpr std::size_t kDigestDigits = 32;

std::string to_line(const json& record) {
  // Names from the user's files may hold any bytes: what is no UTF-8 is replaced, not thrown at.
  const std::string text = record.dump(-1, ' ', false, json::error_handler_t::replace);
  return hash_text(text).hex() + " " + text + "\n";
}

std::optional<json> parse_line(std::string_view line) {
  if (line.size() < kDigestDigits + 1 || line[kDigestDigits] != ' ') return std::nullopt;
  const std::string_view text = line.substr(kDigestDigits + 1);
  if (hash_text(text).hex() != line.substr(0, kDigestDigits)) return std::nullopt;
  json record = json::parse(text, nullptr, false);
  if (!record.is_object()) return std::nullopt;
  return record;
}

json to_json(const ManifestEntry& entry) {
  return {{"task", entry.task},        {"kind", entry.kind},
          {"key", entry.key.hex()},    {"content", entry.content.hex()},
          {"seconds", entry.seconds},  {"cpu_seconds", entry.cpu_seconds},
          {"bytes", entry.bytes},      {"rank", entry.rank},
          {"finished", entry.finished}};
}

ManifestEntry to_entry(const json& record) {
  ManifestEntry entry;
  entry.task = record.at("task");
  entry.kind = record.at("kind");
  entry.key = Digest::from_hex(record.at("key").get<std::string>());
  entry.content = Digest::from_hex(record.at("content").get<std::string>());
  entry.seconds = record.at("seconds");
  entry.cpu_seconds = record.at("cpu_seconds");
  entry.bytes = record.at("bytes");
  entry.rank = record.at("rank");
  entry.finished = record.at("finished");
  return entry;
}

json to_json(const LevelChoice& choice) {
  return {{"choice", choice.bake.hex()},
          {"after", choice.after},
          {"level", choice.level},
          {"predicted", choice.predicted},
          {"used", choice.used}};
}

LevelChoice to_choice(const json& record) {
  LevelChoice choice;
  choice.bake = Digest::from_hex(record.at("choice").get<std::string>());
  choice.after = record.at("after");
  choice.level = record.at("level");
  choice.predicted = record.at("predicted");
  choice.used = record.at("used");
  return choice;
}

/// Takes the records of a manifest, line by line.
class ManifestParser {
 public:
  explicit ManifestParser(const FileSystem::Path& path) : path_(path) { contents_.exists = true; }

  void line(std::string_view text) {
    if (text.empty()) return;  // what a torn line's repair leaves
    const auto record = parse_line(text);
    if (!record) {
      ++contents_.damaged_lines;
      return;
    }
    try {
      sort_in(*record);
    } catch (const json::exception&) {  // sound, but not a record we know
      ++contents_.damaged_lines;
    } catch (const UnsoundData&) {
      ++contents_.damaged_lines;
    }
  }
  ManifestContents take() {
    if (contents_.outdated) {
      contents_.entries.clear();
      contents_.made.clear();
      contents_.choices.clear();
    }
    return std::move(contents_);
  }

 private:
  void sort_in(const json& record) {
    if (record.contains("schema_version")) {
      header(record);
    } else if (record.contains("choice")) {
      contents_.choices.push_back(to_choice(record));
    } else {
      entry(to_entry(record));
    }
  }
  void header(const json& record) {
    const int version = record.at("schema_version");
    if (version > kManifestSchemaVersion) {
      throw UserError(path_.string() + ": made by a newer prtbake (manifest schema " +
                      std::to_string(version) + ", this one knows " +
                      std::to_string(kManifestSchemaVersion) +
                      "); use that one, --fresh or another --out");
    }
    if (contents_.has_header) return;
    contents_.outdated = version < kManifestSchemaVersion;
    contents_.identity = record.at("identity");
    contents_.has_header = true;
  }
  void entry(ManifestEntry entry) {
    if (entry.finished > 0) contents_.made.push_back(entry);
    const auto [place, is_new] = place_of_task_.try_emplace(entry.task, contents_.entries.size());
    if (is_new) {
      contents_.entries.push_back(std::move(entry));
    } else {
      contents_.entries[place->second] = std::move(entry);
    }
  }

  FileSystem::Path path_;
  ManifestContents contents_;
  std::unordered_map<std::string, std::size_t> place_of_task_;
};

}  // namespace

ManifestContents read_manifest(FileSystem& fs, const FileSystem::Path& path) {
  if (!fs.size(path)) return {};
  const auto bytes = fs.read(path);
  std::string_view rest(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  ManifestParser parser(path);
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    parser.line(rest.substr(0, end));
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
  }
  ManifestContents contents = parser.take();
  if (contents.damaged_lines > 0) {
    log::warn("{}: {} torn or damaged line(s) skipped", path.string(), contents.damaged_lines);
  }
  return contents;
}

void create_manifest(FileSystem& fs, const FileSystem::Path& path, const std::string& identity,
                     const std::vector<ManifestEntry>& entries,
                     const std::vector<LevelChoice>& choices) {
  std::string text = to_line({{"schema_version", kManifestSchemaVersion}, {"identity", identity}});
  for (const ManifestEntry& entry : entries) text += to_line(to_json(entry));
  for (const LevelChoice& choice : choices) text += to_line(to_json(choice));
  replace_file(fs, path, std::as_bytes(std::span(text.data(), text.size())));
}

ManifestWriter::ManifestWriter(FileSystem& fs, const FileSystem::Path& path) {
  const auto bytes = fs.size(path) ? fs.read(path) : std::vector<std::byte>{};
  file_ = fs.open_append(path);
  if (!bytes.empty() && bytes.back() != std::byte{'\n'}) file_->append(std::string_view("\n"));
}

ManifestWriter::~ManifestWriter() {
  try {
    sync();
  } catch (const std::exception& error) {
    log::error("{}", error.what());
  }
}

void ManifestWriter::append(const ManifestEntry& entry, double now) {
  file_->append(std::string_view(to_line(to_json(entry))));
  if (!unsynced_) oldest_unsynced_ = now;
  unsynced_ = true;
  sync_if_due(now);
}

void ManifestWriter::append(const LevelChoice& choice) {
  file_->append(std::string_view(to_line(to_json(choice))));
  unsynced_ = true;
  sync();
}

void ManifestWriter::sync_if_due(double now) {
  if (unsynced_ && now - oldest_unsynced_ >= kSyncInterval) sync();
}

void ManifestWriter::sync() {
  if (!unsynced_) return;
  file_->sync();
  unsynced_ = false;
}

}  // namespace prt
