#include "methods/lb/near.h"

#include <cmath>

#include "domains/directions.h"
#include "methods/common/inputs.h"
#include "methods/lb/tasks.h"

namespace prt::lb {

Artifact run_near(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto rays = reader.input(1);
  const HemisphereDirections directions(rays->attribute<int>("directions"));
  const GatherEntries near =
      gather_entries(rays->values<std::uint32_t>("sender"), directions.weights(),
                     shared->samples.size(), task.parameters["near_share"].get<float>());
  std::vector<std::uint16_t> shares;
  double off = 0.0;
  double total = 0.0;
  double all = 0.0;
  for (const float share : near.shares) {
    shares.push_back(pack_share(share));
    off += std::pow(static_cast<float>(shares.back()) / kUnitShare - share, 2);
    total += static_cast<double>(share) * share;
    all += share;
  }
  Artifact out;
  out.put<std::uint32_t>("begin", near.begin, {near.begin.size()}, "1",
                         "first near entry of each sample of the cluster");
  out.put<std::uint32_t>("senders", near.senders, {near.senders.size()}, "1",
                         "samples that fill much of a sample's hemisphere");
  out.put<std::uint16_t>("shares", shares, {shares.size()}, "1/65535",
                         "cosine-weighted share of the hemisphere that each fills");
  const double receivers = std::max<double>(1.0, static_cast<double>(near.begin.size()) - 1.0);
  out.attributes = {{"cluster", task.parameters["cluster"].get<std::uint32_t>()},
                    {"samples", near.begin.size() - 1},
                    {"entries", near.senders.size()},
                    {"mean_share", all / receivers},
                    {"error", total > 0.0 ? std::sqrt(off / total) : 0.0}};
  return out;
}

void append_near(const Artifact& part, NearTransfer& near) {
  const auto begin = part.values<std::uint32_t>("begin");
  const auto senders = part.values<std::uint32_t>("senders");
  const auto shares = part.values<std::uint16_t>("shares");
  if (near.begin.empty()) near.begin = {0};
  const auto before = static_cast<std::uint32_t>(near.senders.size());
  for (std::size_t r = 1; r < begin.size(); ++r) near.begin.push_back(before + begin[r]);
  near.senders.insert(near.senders.end(), senders.begin(), senders.end());
  near.shares.insert(near.shares.end(), shares.begin(), shares.end());
}

std::shared_ptr<const GatherEntries> shared_near(const TaskReader& reader, std::size_t first,
                                                 const ScenePart& part) {
  const std::size_t clusters = part.clusters().size();
  std::string name = "near of " + reader.input_content(0).hex();
  for (std::size_t c = 0; c < clusters; ++c) name += " " + reader.input_content(first + c).hex();
  return reader.memo().get<GatherEntries>(name, [&] {
    NearTransfer near;
    for (std::size_t c = 0; c < clusters; ++c) append_near(*reader.input(first + c), near);
    auto entries = std::make_shared<GatherEntries>();
    entries->begin = {0};
    for (std::size_t r = 0; r + 1 < near.begin.size(); ++r) {
      for (std::uint32_t k = near.begin[r]; k < near.begin[r + 1]; ++k) {
        const std::uint32_t sender = part.local_sample(near.senders[k]);
        if (sender == kNone) continue;
        entries->senders.push_back(sender);
        entries->shares.push_back(static_cast<float>(near.shares[k]) / kUnitShare);
      }
      entries->begin.push_back(static_cast<std::uint32_t>(entries->senders.size()));
    }
    return entries;
  });
}

}  // namespace prt::lb
