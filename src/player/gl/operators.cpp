#include "player/gl/operators.h"

#include <algorithm>
#include <numeric>

namespace prt::gl {
namespace {

/// Parts in which a coefficient's sum is taken: enough invocations for a wide processor.
constexpr int kParts = 16;

int bits_of(const std::vector<QuantisedMatrix>& matrices) {
  std::vector<const QuantisedMatrix*> all;
  all.reserve(matrices.size());
  for (const QuantisedMatrix& m : matrices) all.push_back(&m);
  return QuadRows::bits_of(all);
}

int bits_of(const ClusterTransfer& transfer, QuantisedMatrix ReceiverTransfer::*part) {
  std::vector<const QuantisedMatrix*> all;
  all.reserve(transfer.receivers.size());
  for (const ReceiverTransfer& receiver : transfer.receivers) all.push_back(&(receiver.*part));
  return QuadRows::bits_of(all);
}

/// A shader that reads matrices of so many bits.
Program matrix_program(const char* source, int bits) {
  return Program::compute({"matrix.glsl", source}, bits == 32 ? "#define FLOAT_MATRIX\n" : "");
}

struct ProjectionRows {
  explicit ProjectionRows(int bits) : blocks(bits) {}
  QuadRows blocks;
  std::vector<std::uint32_t> rows, places;
  std::vector<float> scales;
};

ProjectionRows projection_rows(const ClusterProjection& projection, const SampleSet& samples,
                               const CoefficientLayout& layout) {
  ProjectionRows made(bits_of(projection.blocks));
  for (std::uint32_t c = 0; c < projection.blocks.size(); ++c) {
    const QuantisedMatrix& block = projection.blocks[c];
    for (std::uint32_t k = 0; k < block.rows && block.cols > 0; ++k) {
      made.rows.insert(made.rows.end(),
                       {made.blocks.quads(), quads_for(block.cols), samples.cluster_begin[c], 0});
      made.places.push_back(4 * layout.quad(c) + k);
      made.scales.push_back(block.scales[k]);
      for (std::uint32_t i = 0; i < block.cols; ++i) made.blocks.append(block, k, i);
      made.blocks.pad();
    }
  }
  return made;
}

/// The factors of all receivers in the order of the shaders transfer_right and transfer_left.
struct TransferRows {
  TransferRows(const ClusterTransfer& transfer, const CoefficientLayout& coefficients)
      : layout(coefficients),
        channels(transfer.channels),
        right(bits_of(transfer, &ReceiverTransfer::right)),
        left(bits_of(transfer, &ReceiverTransfer::left)) {}

  void add(const ReceiverTransfer& receiver, std::uint32_t first_sample, std::uint32_t samples) {
    const bool empty = receiver.left.rows == 0 || receiver.left.cols == 0 ||
                       receiver.right.rows == 0 || receiver.right.cols == 0;
    const std::uint32_t rank = empty ? 0 : receiver.left.cols;
    receivers.insert(receivers.end(), {left.quads(), quads_for(rank), reduced_quads, first_sample});
    for (std::uint32_t i = 0; i < samples; ++i) {
      for (std::uint32_t k = 0; k < rank; ++k) left.append(receiver.left, i, k);
      left.pad();
      left_scales.push_back(rank == 0 ? 0.0F : receiver.left.scales[i]);
    }
    if (rank == 0) return;
    const auto first_column = static_cast<std::uint32_t>(columns.size());
    for (const std::uint32_t sender : receiver.senders) {
      for (std::uint32_t q = 0; q < quads_for(layout.functions(sender)); ++q) {
        columns.push_back(layout.quad(sender) + q);
      }
    }
    const auto quads = static_cast<std::uint32_t>(columns.size()) - first_column;
    for (std::uint32_t k = 0; k < rank; ++k) {
      rows.insert(rows.end(), {right.quads(), quads, first_column, 4 * reduced_quads + k});
      right_scales.push_back(receiver.right.scales[k]);
      add_row(receiver, k);
    }
    reduced_quads += quads_for(rank);
  }

  const CoefficientLayout& layout;
  std::uint32_t channels;
  QuadRows right, left;
  std::vector<std::uint32_t> rows, columns, receivers;
  std::vector<float> right_scales, left_scales;
  std::uint32_t reduced_quads = 0;

 private:
  void add_row(const ReceiverTransfer& receiver, std::uint32_t k) {
    std::uint32_t column = 0;
    for (std::uint32_t channel = 0; channel < channels; ++channel) {
      for (const std::uint32_t sender : receiver.senders) {
        for (std::uint32_t f = 0; f < layout.functions(sender); ++f) {
          right.append(receiver.right, k, column++);
        }
        right.pad();
      }
    }
  }
};

/// Receivers by falling number of senders: neighbours in the list work equally long.
std::vector<std::uint32_t> by_length(const std::vector<std::uint32_t>& begin) {
  std::vector<std::uint32_t> order(begin.size() - 1);
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return begin[a + 1] - begin[a] > begin[b + 1] - begin[b];
  });
  return order;
}

}  // namespace

CoefficientLayout::CoefficientLayout(const std::vector<std::uint32_t>& begin) : quad_begin_{0} {
  for (std::size_t c = 0; c + 1 < begin.size(); ++c) {
    functions_.push_back(begin[c + 1] - begin[c]);
    quad_begin_.push_back(quad_begin_.back() + quads_for(functions_.back()));
  }
}

CoefficientLayout::CoefficientLayout(const ClusterProjection& projection)
    : CoefficientLayout(projection.coefficient_begin()) {}

ProjectionPass::ProjectionPass(const ClusterProjection& projection, const SampleSet& samples)
    : layout_(projection),
      parts_(matrix_program("project.glsl", bits_of(projection.blocks))),
      sum_(Program::compute({"project_sum.glsl"})) {
  const ProjectionRows made = projection_rows(projection, samples, layout_);
  rows_count_ = static_cast<int>(made.scales.size());
  rows_ = texels(GL_RGBA32UI, 16, made.rows);
  blocks_ = made.blocks.upload();
  scales_ = texels(GL_R32F, 4, made.scales);
  places_ = texels(GL_R32UI, 4, made.places);
  partial_ = TexelBuffer(GL_RGBA32F, 16, static_cast<std::size_t>(rows_count_) * kParts);
}

void ProjectionPass::run(const TexelBuffer& irradiance, const TexelBuffer& coefficients) {
  const auto rows = static_cast<std::size_t>(rows_count_);
  parts_.use();
  parts_.set("count", rows_count_ * kParts);
  parts_.set("parts", kParts);
  irradiance.read_at(0);
  rows_.read_at(1);
  blocks_.read_at(2);
  partial_.write_at(0);
  dispatch(rows * kParts, kGroup);
  sum_.use();
  sum_.set("count", rows_count_);
  sum_.set("parts", kParts);
  sum_.set("padded", static_cast<int>(4 * layout_.channel_quads()));
  partial_.read_at(0);
  scales_.read_at(1);
  places_.read_at(2);
  coefficients.write_at(0);
  dispatch(rows, kGroup);
}

TransferPass::TransferPass(const ClusterTransfer& transfer, const CoefficientLayout& layout,
                           const SampleSet& samples, const SampleBuffers& buffers)
    : buffers_(&buffers),
      channel_quads_(layout.channel_quads()),
      coloured_(transfer.channels == 1 ? 0 : 1),
      to_reduced_(
          matrix_program("transfer_right.glsl", bits_of(transfer, &ReceiverTransfer::right))),
      to_samples_(
          matrix_program("transfer_left.glsl", bits_of(transfer, &ReceiverTransfer::left))) {
  TransferRows made(transfer, layout);
  for (std::uint32_t r = 0; r < transfer.receivers.size(); ++r) {
    made.add(transfer.receivers[r], samples.cluster_begin[r], samples.cluster_size(r));
  }
  rows_count_ = static_cast<int>(made.right_scales.size());
  reduced_quads_ = made.reduced_quads;
  rows_ = texels(GL_RGBA32UI, 16, made.rows);
  columns_ = texels(GL_R32UI, 4, made.columns);
  right_ = made.right.upload();
  right_scales_ = texels(GL_R32F, 4, made.right_scales);
  receivers_ = texels(GL_RGBA32UI, 16, made.receivers);
  left_ = made.left.upload();
  left_scales_ = texels(GL_R32F, 4, made.left_scales);
  reduced_ = TexelBuffer(GL_RGBA32F, 16, std::size_t{3} * reduced_quads_);
}

void TransferPass::run(const TexelBuffer& coefficients, const TexelBuffer& irradiance) {
  to_reduced_.use();
  to_reduced_.set("count", 3 * rows_count_);
  to_reduced_.set("coloured", coloured_);
  to_reduced_.set("channel_quads", static_cast<int>(channel_quads_));
  to_reduced_.set("padded", static_cast<int>(4 * reduced_quads_));
  coefficients.read_at(0);
  rows_.read_at(1);
  columns_.read_at(2);
  right_.read_at(3);
  right_scales_.read_at(4);
  reduced_.write_at(0);
  dispatch(std::size_t{3} * static_cast<std::size_t>(rows_count_), kGroup);
  to_samples_.use();
  to_samples_.set("channel_quads", static_cast<int>(reduced_quads_));
  reduced_.read_at(0);
  buffers_->groups.read_at(1);
  receivers_.read_at(2);
  left_.read_at(3);
  left_scales_.read_at(4);
  irradiance.write_at(0);
  dispatch(buffers_->group_count * kGroup, kGroup);
}

NearPass::NearPass(const NearTransfer& near)
    : count_(static_cast<int>(near.begin.size() - 1)),
      reflect_(Program::compute({"exitant.glsl"})),
      gather_(Program::compute({"near.glsl"})) {
  constexpr std::size_t kShortIndices = 65536;
  std::vector<std::uint32_t> receivers;
  for (const std::uint32_t r : by_length(near.begin)) {
    receivers.insert(receivers.end(), {r, near.begin[r], near.begin[r + 1], 0});
  }
  receivers_ = texels(GL_RGBA32UI, 16, receivers);
  if (static_cast<std::size_t>(count_) <= kShortIndices) {
    std::vector<std::uint16_t> pairs;
    for (std::size_t k = 0; k < near.senders.size(); ++k) {
      pairs.insert(pairs.end(), {static_cast<std::uint16_t>(near.senders[k]), near.shares[k]});
    }
    senders_ = texels(GL_RG16UI, 4, pairs);
  } else {
    std::vector<std::uint32_t> pairs;
    for (std::size_t k = 0; k < near.senders.size(); ++k) {
      pairs.insert(pairs.end(), {near.senders[k], near.shares[k]});
    }
    senders_ = texels(GL_RG32UI, 8, pairs);
  }
  std::vector<Eigen::Vector4f> albedo;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    const std::uint16_t* a = &near.albedo[i * near.channels];
    const std::size_t step = near.channels == 1 ? 0 : 1;
    albedo.emplace_back(Eigen::Vector4f(a[0], a[step], a[2 * step], 0.0F) / kUnitShare);
  }
  albedo_ = vec4_texels(albedo);
  exitant_ = TexelBuffer(GL_RGBA32F, 16, static_cast<std::size_t>(count_));
}

void NearPass::run(const SampleValue& value, const TexelBuffer& direct,
                   const TexelBuffer& received) {
  const auto items = static_cast<std::size_t>(count_);
  reflect_.use();
  reflect_.set("direct_share", value.direct_share);
  reflect_.set("other_share", value.rest != nullptr ? 1.0F : 0.0F);
  reflect_.set("count", count_);
  direct.read_at(0);
  (value.rest != nullptr ? *value.rest : direct).read_at(1);
  albedo_.read_at(2);
  exitant_.write_at(0);
  dispatch(items, kGroup);
  gather_.use();
  gather_.set("count", count_);
  exitant_.read_at(0);
  receivers_.read_at(1);
  senders_.read_at(2);
  received.write_at(0);
  dispatch(items, kGroup);
}

void CombinePass::run(float a_share, const TexelBuffer& a, float b_share, const TexelBuffer& b,
                      const TexelBuffer& sum) {
  program_.use();
  program_.set("a_share", a_share);
  program_.set("b_share", b_share);
  program_.set("count", static_cast<int>(sum.texels()));
  a.read_at(0);
  b.read_at(1);
  sum.write_at(0);
  dispatch(sum.texels(), kGroup);
}

}  // namespace prt::gl
