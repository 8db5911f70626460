#include "store/index.h"

#include <cstdio>

#include "store/bake_folder.h"
#include "store_fixtures.h"

namespace prt {
namespace {

std::string output_of(const std::string& command) {
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::string output;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) output += static_cast<char>(c);
  EXPECT_EQ(pclose(pipe), 0) << command << "\n" << output;
  return output;
}

const std::vector<IndexEntry> kEntries = {{"samples", "samples", hash_text("a")},
                                          {"rays/0000", "rays", hash_text("b")},
                                          {"error/lb/0000", "evaluate", hash_text("c")}};

class IndexTest : public testing::Test {
 protected:
  void SetUp() override {
    ArtifactStore store(disk_, folder_.path());
    for (const auto& entry : kEntries) store.write(entry.kind, entry.key, varied_artifact());
    write_index(disk_, folder_.path(), kEntries);
  }
  TemporaryFolder folder_;
  PosixFileSystem disk_;
};

TEST_F(IndexTest, AlwaysTwoLevels) {
  EXPECT_EQ(index_path(kEntries[0]), "/samples/samples");
  EXPECT_EQ(index_path(kEntries[1]), "/rays/0000");
  EXPECT_EQ(index_path(kEntries[2]), "/evaluate/error.lb.0000");
}

TEST_F(IndexTest, H5lsSeesEveryDataset) {
  const std::string list = output_of("h5ls -rE " + (folder_.path() / kIndexName).string());
  for (const auto& entry : kEntries) {
    for (const auto& [name, dataset] : varied_artifact().datasets) {
      EXPECT_NE(list.find(index_path(entry) + "/" + name), std::string::npos) << list;
    }
  }
}

TEST_F(IndexTest, H5dumpReadsASealedArtifact) {
  const std::string file = ArtifactStore(disk_, folder_.path()).path("rays", hash_text("b"));
  const std::string dump = output_of("h5dump " + file);
  EXPECT_NE(dump.find("(0,0): 0, 1, 2"), std::string::npos) << dump;
  EXPECT_NE(dump.find("\"Leonhardt"), dump.find("equation")) << dump;
}

TEST_F(IndexTest, KeepsAttributesOfTheBake) {
  write_index(disk_, folder_.path(), kEntries, {{"origin", {1e5, 0.5, -2}}});
  const std::string dump = output_of("h5dump -A " + (folder_.path() / kIndexName).string());
  EXPECT_NE(dump.find("[100000.0,0.5,-2]"), std::string::npos) << dump;
  EXPECT_NE(dump.find("json:origin"), std::string::npos) << dump;
  EXPECT_EQ(read_index(disk_, folder_.path()).size(), kEntries.size());
}

TEST_F(IndexTest, EqualBytesInAnyOrder) {
  const std::string first = read_text(folder_.path() / kIndexName);
  const std::vector<IndexEntry> reversed(kEntries.rbegin(), kEntries.rend());
  write_index(disk_, folder_.path(), reversed);
  EXPECT_EQ(read_text(folder_.path() / kIndexName), first);
}

TEST_F(IndexTest, TellsTheKeysItLinksTo) {
  std::set<Digest> keys;
  for (const auto& entry : kEntries) keys.insert(entry.key);
  EXPECT_EQ(read_index(disk_, folder_.path()), keys);
  std::string bytes = read_text(folder_.path() / kIndexName);
  bytes[100] ^= 1;
  write_text(folder_.path() / kIndexName, bytes);
  EXPECT_THROW(read_index(disk_, folder_.path()), UnsoundData);
}

TEST_F(IndexTest, HoldsThousandsOfTasks) {
  std::vector<IndexEntry> many;
  for (int i = 0; i < 5000; ++i) {
    many.push_back({"rays/" + std::to_string(i), "rays", hash_text(std::to_string(i))});
  }
  write_index(disk_, folder_.path(), many);
  const std::string list = output_of("h5ls " + (folder_.path() / kIndexName).string() + "/rays");
  EXPECT_EQ(std::count(list.begin(), list.end(), '\n'), 5000);
}

TEST_F(IndexTest, AnEmptyBakeHasAnIndex) {
  write_index(disk_, folder_.path(), {});
  EXPECT_EQ(output_of("h5ls " + (folder_.path() / kIndexName).string()), "");
}

}  // namespace
}  // namespace prt
