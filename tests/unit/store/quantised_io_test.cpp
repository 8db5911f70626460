#include "store/quantised_io.h"

#include "store_fixtures.h"

namespace prt {
namespace {

class QuantisedIo : public testing::TestWithParam<int> {
 protected:
  static QuantisedMatrix matrix() {
    MatrixF m(3, 4);
    m << 0, 1, -2, 3, 0, 0, 0, 0, 1e-3F, -5e-4F, 2e-4F, 7e-4F;
    return quantise(m, GetParam()).matrix;
  }
};

TEST_P(QuantisedIo, ComesBackThroughAFile) {
  Artifact artifact;
  put_quantised(artifact, "basis", matrix(), "m", "a basis");
  const Artifact read = from_hdf5(to_hdf5(artifact, test_label())).artifact;
  const QuantisedMatrix back = get_quantised(read, "basis");
  EXPECT_EQ(back.rows, 3U);
  EXPECT_EQ(back.cols, 4U);
  EXPECT_EQ(back.bits, GetParam());
  EXPECT_EQ(back.scales, matrix().scales);
  EXPECT_EQ(back.int8, matrix().int8);
  EXPECT_EQ(back.int16, matrix().int16);
  EXPECT_EQ(back.float32, matrix().float32);
  EXPECT_EQ(back.decode(), matrix().decode());
}

TEST_P(QuantisedIo, RefusesArraysThatDoNotFit) {
  Artifact artifact;
  EXPECT_THROW(get_quantised(artifact, "basis"), UnsoundData);
  put_quantised(artifact, "basis", matrix(), "m", "a basis");
  artifact.datasets["basis"].dims = {12};
  EXPECT_THROW(get_quantised(artifact, "basis"), UnsoundData);
  artifact.datasets["basis"].dims = {4, 3};
  EXPECT_THROW(get_quantised(artifact, "basis"), UnsoundData);
  artifact.datasets.erase("basis.scale");
  EXPECT_THROW(get_quantised(artifact, "basis"), UnsoundData);
  put_counting<std::uint32_t>(artifact, "basis", {3, 4});
  EXPECT_THROW(get_quantised(artifact, "basis"), UnsoundData);
}

INSTANTIATE_TEST_SUITE_P(Bits, QuantisedIo, testing::Values(8, 16, 32));

TEST(QuantisedIoEmpty, ComesBack) {
  Artifact artifact;
  put_quantised(artifact, "none", quantise(MatrixF(0, 5), 8).matrix, "1", "nothing");
  const QuantisedMatrix back =
      get_quantised(from_hdf5(to_hdf5(artifact, test_label())).artifact, "none");
  EXPECT_EQ(back.rows, 0U);
  EXPECT_EQ(back.cols, 5U);
  EXPECT_EQ(back.bits, 8);
}

}  // namespace
}  // namespace prt
