#include "evaluate/points_csv.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <sstream>

#include "base/error.h"

namespace prt {
namespace {

class PointsCsv : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& text) {
    const auto path = folder_ / "in.csv";
    std::ofstream(path) << text;
    return path;
  }
  std::string complaint(const std::string& text) {
    try {
      read_points_csv(file(text));
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  }
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("points_csv_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(PointsCsv, ReadsPointsAndMakesNormalsUnit) {
  const auto points =
      read_points_csv(file("x,y,z,nx,ny,nz\r\n1,2.5,-3e-1,0,2,0\n\n 4, 5 ,6,1e-30,0,0\n"));
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].position, Vec3d(1, 2.5, -0.3));
  EXPECT_EQ(points[0].normal, Vec3f(0, 1, 0));
  EXPECT_EQ(points[1].position, Vec3d(4, 5, 6));
  EXPECT_EQ(points[1].normal, Vec3f(1, 0, 0));
}

TEST_F(PointsCsv, TakesPointsToTheSceneInDouble) {
  const auto points =
      read_points_csv(file("x,y,z,nx,ny,nz\n1e8,0,-1e8,0,1,0\n100000000.25,1,2,0,1,0\n"));
  const auto placed = points_in(Vec3d(1e8, 0, 0), points);
  ASSERT_EQ(placed.size(), 2U);
  EXPECT_EQ(placed[0].position, Vec3f(0, 0, -1e8F));
  EXPECT_EQ(placed[1].position, Vec3f(0.25F, 1, 2)) << "1e8 + 0.25 is no float";
  EXPECT_EQ(placed[1].normal, Vec3f(0, 1, 0));
}

TEST_F(PointsCsv, NamesTheLineThatIsWrong) {
  const std::string header = "x,y,z,nx,ny,nz\n";
  const std::pair<std::string, std::string> wrong[] = {
      {"", ":1:"},
      {"x,y,z\n1,2,3\n", ":1:"},
      {header + "1,2,3,0,1\n", ":2: 5 columns"},
      {header + "1,2,3,0,1,0\n1,2,3,0,1,0,7\n", ":3: 7 columns"},
      {header + "1,2,3,0,1,zero\n", ":2: 'zero' in column 6"},
      {header + "1,,3,0,1,0\n", ":2: '' in column 2"},
      {header + "1,2,nan,0,1,0\n", ":2: 'nan' in column 3"},
      {header + "1,2,1e99,0,1,0\n", ":2: '1e99' in column 3"},
      {header + "\n1,2,3,0,0,0\n", ":3: the normal is zero"},
      {header, "no points"},
  };
  for (const auto& [text, expected] : wrong) {
    EXPECT_NE(complaint(text).find(expected), std::string::npos)
        << text << " -> " << complaint(text);
  }
  EXPECT_THROW(read_points_csv(folder_ / "missing.csv"), UserError);
}

TEST_F(PointsCsv, WrittenValuesReadBackExactly) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<WorldPoint> points = {{Vec3d(100000.1, 1.0 / 3.0, -2), Vec3f(0, 1, 0)}};
  const std::vector<PointIrradiance> values = {{Vec3f(1.1F, -2.2F, 1e-20F), Vec3f(nan, 0, 7)}};
  write_points_csv(folder_ / "out.csv", points, values);
  std::ifstream in(folder_ / "out.csv");
  std::string header, line, cell;
  std::getline(in, header);
  EXPECT_EQ(header, "x,y,z,nx,ny,nz,direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b");
  std::getline(in, line);
  std::vector<std::string> cells;
  for (std::istringstream row(line); std::getline(row, cell, ',');) cells.push_back(cell);
  ASSERT_EQ(cells.size(), 12U);
  EXPECT_EQ(cells[0], "100000.1") << "as it came in";
  EXPECT_EQ(std::stod(cells[1]), 1.0 / 3.0);
  EXPECT_EQ(cells[2], "-2");
  EXPECT_EQ(std::stof(cells[6]), 1.1F);
  EXPECT_EQ(std::stof(cells[8]), 1e-20F);
  EXPECT_EQ(cells[9], "nan");
  EXPECT_THROW(write_points_csv(folder_ / "no" / "folder.csv", points, values), UserError);
}

}  // namespace
}  // namespace prt
