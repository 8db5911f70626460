#include "store/bake_folder.h"

#include "store/index.h"
#include "store_fixtures.h"

namespace prt {
namespace {

namespace fs = std::filesystem;

ManifestEntry entry(const std::string& task) {
  return {.task = task,
          .kind = "rays",
          .key = hash_text(task),
          .content = hash_text(task + " content"),
          .seconds = 1.25,
          .cpu_seconds = 1.0,
          .bytes = 12345,
          .rank = 1,
          .finished = 1795324800};
}

class BakeFolderTest : public testing::Test {
 protected:
  BakeFolder open(const std::string& identity = "gallery.glb", bool fresh = false) {
    return BakeFolder::open(disk_, bake_, identity, fresh);
  }
  std::string refusal(const std::string& identity = "gallery.glb", bool fresh = false) {
    try {
      open(identity, fresh);
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  }
  std::vector<ManifestEntry> entries() { return read_manifest(disk_, manifest_).entries; }
  /// A bake with two finished tasks; returns the manifest's text.
  std::string bake_two() {
    auto folder = open();
    folder.manifest().append(entry("rays/0000"), 0.0);
    folder.manifest().append(entry("rays/0001"), 0.0);
    return read_text(manifest_);
  }

  TemporaryFolder folder_;
  fs::path bake_ = folder_.path() / "out" / "gallery";
  fs::path manifest_ = bake_ / kManifestName;
  PosixFileSystem disk_;
};

TEST_F(BakeFolderTest, RemembersFinishedTasks) {
  bake_two();
  const auto folder = open();
  EXPECT_TRUE(folder.found().has_header);
  EXPECT_EQ(folder.found().identity, "gallery.glb");
  EXPECT_EQ(folder.found().damaged_lines, 0U);
  EXPECT_EQ(folder.found().entries,
            (std::vector<ManifestEntry>{entry("rays/0000"), entry("rays/0001")}));
}

TEST_F(BakeFolderTest, TheLastLineOfATaskCounts) {
  bake_two();
  ManifestEntry again = entry("rays/0000");
  again.key = hash_text("with other options");
  open().manifest().append(again, 0.0);
  EXPECT_EQ(entries(), (std::vector<ManifestEntry>{again, entry("rays/0001")}));
}

TEST_F(BakeFolderTest, KnowsWhatEveryMakingTookWhenATaskGoesBackToEarlierSettings) {
  ManifestEntry first = entry("rays/0001"), second = first, found = first;
  first.finished = 100;
  first.seconds = 4.0;
  second.key = hash_text("other settings");
  second.finished = 200;
  found.finished = 0;  // what an artifact that was only found leaves
  found.seconds = 0.0;
  for (const ManifestEntry& line : {first, second, found}) open().manifest().append(line, 0.0);
  EXPECT_EQ(entries(), std::vector{found});
  EXPECT_EQ(read_manifest(disk_, manifest_).made, (std::vector{first, second}));
}

TEST_F(BakeFolderTest, RefusesAnotherBakeUnlessFresh) {
  bake_two();
  const std::string message = refusal("sponza.glb");
  EXPECT_NE(message.find("holds another bake (gallery.glb)"), std::string::npos) << message;
  EXPECT_NE(message.find("--fresh or another --out"), std::string::npos) << message;
  EXPECT_EQ(entries().size(), 2U);
  EXPECT_EQ(refusal("sponza.glb", true), "");
  EXPECT_TRUE(entries().empty());
  EXPECT_EQ(read_manifest(disk_, manifest_).identity, "sponza.glb");
}

TEST_F(BakeFolderTest, FreshRemovesOurFilesOnly) {
  {
    auto folder = open();
    folder.store().write("rays", hash_text("key"), varied_artifact());
    write_index(disk_, bake_, {});
  }
  write_text(bake_ / "notes.txt", "mine");
  const auto folder = open("gallery.glb", true);
  EXPECT_TRUE(folder.found().entries.empty());
  EXPECT_FALSE(fs::exists(bake_ / kIndexName));
  EXPECT_TRUE(fs::exists(bake_ / "notes.txt"));
  EXPECT_TRUE(disk_.list(bake_ / "artifacts" / "rays").empty());
}

TEST_F(BakeFolderTest, OneBakeAtATime) {
  const auto folder = open();
  const std::string message = refusal();
  EXPECT_NE(message.find("another bake is writing here (process " + std::to_string(getpid())),
            std::string::npos)
      << message;
}

TEST_F(BakeFolderTest, RemovesLeftOversOfAKilledBake) {
  bake_two();
  const fs::path left_over = bake_ / "artifacts" / "rays" / "0123.h5.99.1.tmp";
  fs::create_directories(left_over.parent_path());
  write_text(left_over, "half");
  open();
  EXPECT_FALSE(fs::exists(left_over));
}

TEST_F(BakeFolderTest, EveryTornEndIsSkippedAndMended) {
  const std::string whole = bake_two();
  const std::size_t first_two = whole.find('\n', whole.find('\n') + 1) + 1;
  for (std::size_t length = first_two; length < whole.size(); ++length) {
    write_text(manifest_, whole.substr(0, length));
    open().manifest().append(entry("rays/0002"), 0.0);
    const auto contents = read_manifest(disk_, manifest_);
    // Without its newline alone, the second line is still whole.
    const bool kept = length == whole.size() - 1;
    ASSERT_EQ(contents.entries.size(), kept ? 3U : 2U) << length;
    EXPECT_EQ(contents.entries.front(), entry("rays/0000"));
    EXPECT_EQ(contents.entries.back(), entry("rays/0002"));
  }
}

TEST_F(BakeFolderTest, AFlipInAnyByteCostsItsLinesOnly) {
  const std::string whole = bake_two();
  const std::size_t header = whole.find('\n') + 1;
  for (std::size_t at = header; at < whole.size(); ++at) {
    std::string text = whole;
    text[at] = static_cast<char>(text[at] ^ (1 << (at % 8)));
    write_text(manifest_, text);
    const auto contents = read_manifest(disk_, manifest_);
    ASSERT_TRUE(contents.has_header);
    ASSERT_LE(contents.entries.size(), 1U) << at;
    for (const auto& found : contents.entries) {
      ASSERT_EQ(found, entry(found.task));
    }
  }
}

TEST_F(BakeFolderTest, ADamagedHeaderIsMended) {
  std::string text = bake_two();
  text[40] ^= 1;
  write_text(manifest_, text);
  EXPECT_EQ(open().found().entries.size(), 2U);
  const auto contents = read_manifest(disk_, manifest_);
  EXPECT_TRUE(contents.has_header);
  EXPECT_EQ(contents.entries.size(), 2U);
  EXPECT_EQ(contents.damaged_lines, 0U);
}

TEST_F(BakeFolderTest, AForeignManifestIsRefusedUnlessFresh) {
  fs::create_directories(bake_);
  for (const std::string& text :
       {std::string(), std::string("a log of something else\n"), std::string("\0\xFF\n\n\n", 5)}) {
    write_text(manifest_, text);
    EXPECT_NE(refusal().find("is no manifest of a bake; use --fresh or another --out"),
              std::string::npos);
    EXPECT_EQ(read_text(manifest_), text);
  }
  EXPECT_EQ(refusal("gallery.glb", true), "");
}

TEST_F(BakeFolderTest, AnOlderBakesEntriesCountForNothing) {
  const std::string begun = bake_two();
  const std::string json = R"({"identity":"gallery.glb","schema_version":1})";
  write_text(manifest_,
             hash_text(json).hex() + " " + json + "\n" + begun.substr(begun.find('\n') + 1));
  EXPECT_THROW(read_bake(disk_, bake_), UserError);
  EXPECT_TRUE(open().found().entries.empty());
  EXPECT_FALSE(read_bake(disk_, bake_).outdated) << "it is a bake of this version now";
}

TEST_F(BakeFolderTest, ANewerManifestIsRefused) {
  fs::create_directories(bake_);
  const std::string json = R"({"identity":"gallery.glb","schema_version":99})";
  write_text(manifest_, hash_text(json).hex() + " " + json + "\n");
  EXPECT_NE(refusal().find("made by a newer prtbake"), std::string::npos);
}

TEST_F(BakeFolderTest, AFolderThatCannotBeMadeIsTold) {
  write_text(folder_.path() / "out", "a file");
  EXPECT_NE(refusal().find("cannot make the folder"), std::string::npos);
}

TEST_F(BakeFolderTest, ReadsABakeWithoutTouchingIt) {
  EXPECT_THROW(read_bake(disk_, bake_), UserError);
  fs::create_directories(bake_);
  EXPECT_THROW(read_bake(disk_, bake_), UserError);
  const std::string text = bake_two();
  const auto folder = open();  // a bake at work does not bar readers
  EXPECT_EQ(read_bake(disk_, bake_).entries.size(), 2U);
  EXPECT_EQ(read_text(manifest_), text);
}

/// Counts syncs of the manifest.
class CountingFileSystem : public PosixFileSystem {
 public:
  std::unique_ptr<WritableFile> open_append(const Path& path) override {
    return std::make_unique<File>(PosixFileSystem::open_append(path), syncs);
  }
  int syncs = 0;

 private:
  struct File : WritableFile {
    File(std::unique_ptr<WritableFile> inner, int& syncs)
        : inner_(std::move(inner)), syncs_(syncs) {}
    using WritableFile::append;
    void append(std::span<const std::byte> bytes) override { inner_->append(bytes); }
    void sync() override {
      ++syncs_;
      inner_->sync();
    }
    std::unique_ptr<WritableFile> inner_;
    int& syncs_;
  };
};

TEST_F(BakeFolderTest, KeepsChoicesThroughADamagedHeaderAndSyncsThemAtOnce) {
  CountingFileSystem disk;
  const LevelChoice first{hash_text("settings"), 0, 2, 12.5, 3.25};
  const LevelChoice second{hash_text("settings"), 2, 2, 99.0, 14.0};
  {
    auto folder = BakeFolder::open(disk, bake_, "gallery.glb", false);
    folder.manifest().append(entry("a"), 100.0);
    folder.manifest().append(first);
    EXPECT_EQ(disk.syncs, 1);
    folder.manifest().append(second);
  }
  std::string text = read_text(manifest_);
  text[0] = text[0] == '0' ? '1' : '0';
  write_text(manifest_, text);
  EXPECT_EQ(BakeFolder::open(disk, bake_, "gallery.glb", false).found().choices,
            (std::vector{first, second}));
  EXPECT_EQ(read_manifest(disk, manifest_).choices, (std::vector{first, second}));
  EXPECT_EQ(entries().size(), 1U);
  EXPECT_TRUE(BakeFolder::open(disk, bake_, "gallery.glb", true).found().choices.empty());
}

TEST_F(BakeFolderTest, SyncsInGroupsOfHalfASecond) {
  CountingFileSystem disk;
  auto folder = BakeFolder::open(disk, bake_, "gallery.glb", false);
  ManifestWriter& manifest = folder.manifest();
  manifest.sync_if_due(99.0);
  EXPECT_EQ(disk.syncs, 0);  // nothing waits
  manifest.append(entry("a"), 100.0);
  manifest.append(entry("b"), 100.2);
  manifest.sync_if_due(100.4);
  EXPECT_EQ(disk.syncs, 0);
  EXPECT_EQ(entries().size(), 2U);  // readable at once
  manifest.sync_if_due(100.5);
  EXPECT_EQ(disk.syncs, 1);
  manifest.append(entry("c"), 101.0);
  manifest.append(entry("d"), 101.6);
  EXPECT_EQ(disk.syncs, 2);
  manifest.append(entry("e"), 102.0);
  manifest.sync();
  EXPECT_EQ(disk.syncs, 3);
}

}  // namespace
}  // namespace prt
