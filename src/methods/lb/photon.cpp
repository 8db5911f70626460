#include "base/random.h"
#include "methods/common/inputs.h"
#include "methods/lb/tasks.h"
#include "transport/photons.h"

namespace prt::lb {

Artifact run_photons(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto search = shared_search(reader, 0);
  const auto functions = shared_functions(reader, 1);
  const auto& p = task.parameters;
  const auto cluster = p["cluster"].get<std::uint32_t>();
  const MatrixF own = functions->values
                          .block(shared->samples.cluster_begin[cluster], 0,
                                 shared->samples.cluster_size(cluster), functions->of(cluster))
                          .transpose();
  CellPoints points;
  for (std::size_t i = 2; i < task.inputs.size(); ++i) append_cell_points(*reader.input(i), points);
  PhotonSettings settings;
  settings.photons = p["photons"].get<std::uint64_t>();
  settings.bounces = p["bounces"].get<int>();
  settings.stream = stream_key(p["seed"].get<std::uint64_t>(), numbered("photons", cluster));
  const PhotonTransfer shot = blaming_the_scene([&] {
    return shoot_photons(reader.scene(), reader.ray_caster(), shared->samples, *search, points,
                         cluster, own, p["channels"].get<int>(), settings);
  });
  Artifact out;
  out.put("irradiance", shot.irradiance, "W/m^2",
          "indirect irradiance at all samples by each light function, channels side by side");
  out.attributes = {{"cluster", cluster},          {"samples", own.cols()},
                    {"photons", settings.photons}, {"flights", shot.flights},
                    {"escaped", shot.escaped},     {"lost", shot.lost}};
  return out;
}

Artifact run_photon_transfer(const TaskSpec& task, const TaskReader& reader) {
  const auto shared = shared_samples(reader, 0);
  const auto functions = shared_functions(reader, 1);
  const auto& p = task.parameters;
  const auto cluster = p["cluster"].get<std::uint32_t>();
  const std::uint32_t first = shared->samples.cluster_begin[cluster];
  const std::uint32_t rows = shared->samples.cluster_size(cluster);
  const auto typical = shared_light_coefficients(reader, 1);
  std::vector<ChannelTransfer> transfer(p["channels"].get<std::size_t>());
  for (ChannelTransfer& t : transfer) t.once = MatrixF(rows, functions->count());
  for (std::size_t s = 0; s + 2 < task.inputs.size(); ++s) {
    const auto part = reader.input(s + 2);
    const auto values = part->values<float>("irradiance");
    const auto columns = static_cast<Eigen::Index>(part->at("irradiance").dims.at(1));
    const Eigen::Map<const MatrixF> received(values.data() + first * columns, rows, columns);
    const Eigen::Index k = functions->of(s);
    for (std::size_t c = 0; c < transfer.size(); ++c) {
      transfer[c].once.middleCols(functions->begin[s], k) =
          received.middleCols(static_cast<Eigen::Index>(c) * k, k);
    }
  }
  std::vector<MatrixF> fields;
  fields.reserve(transfer.size());
  for (const ChannelTransfer& t : transfer) fields.emplace_back(t.once * *typical);
  Artifact out = compress_transfer(
      transfer, fields, cluster_areas(shared->samples, cluster), functions->begin, *typical,
      {p["bits"].get<int>(), p["rank"].get<int>(), p["tolerance"].get<double>()});
  out.attributes["cluster"] = cluster;
  out.attributes["samples"] = rows;
  return out;
}

}  // namespace prt::lb
