#include "apps/inspect/inspect.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "apps/inspect/basis_image.h"
#include "apps/inspect/clusters_image.h"
#include "apps/inspect/curves.h"
#include "apps/inspect/depth_image.h"
#include "apps/inspect/sky_image.h"
#include "apps/inspect/tables.h"
#include "apps/inspect/verify.h"
#include "apps/inspect/watch.h"
#include "base/atomic_file.h"
#include "base/image_file.h"
#include "store/samples_io.h"

namespace prt {

namespace {

void write(const Drawing& picture, const std::filesystem::path& path) {
  write_png(path, picture.width(), picture.height(), picture.rgb());
}

ClusterValues values_of(const std::string& image, const BakeReader& bake, std::size_t clusters) {
  if (image == "rank") return light_function_counts(*bake.artifact("light_functions"));
  std::vector<double> errors(clusters, std::numeric_limits<double>::quiet_NaN());
  const BakeTables tables = make_tables(bake);
  for (const ClusterRow& row : tables.clusters) {
    for (const char* stage : {"transfer", "photon_transfer"}) {
      const auto it = row.figures.find(stage);
      if (it == row.figures.end() || !it->second.error.is_number()) continue;
      if (row.cluster < 0 || static_cast<std::size_t>(row.cluster) >= clusters) continue;
      errors[static_cast<std::size_t>(row.cluster)] = it->second.error.get<double>();
    }
  }
  if (std::ranges::all_of(errors, [](double e) { return std::isnan(e); })) {
    throw UserError(bake.path().string() + ": no finished transfer in this bake has an error");
  }
  return transfer_errors(std::move(errors));
}

void draw_image(const InspectCommand& command, const BakeReader& bake, std::string& out) {
  if (command.image == "depth") {
    write(draw_depth(bake, command.cluster, command.index.value_or(0)), command.output);
  } else if (command.image == "basis") {
    write(draw_basis(bake, command.cluster, command.index), command.output);
  } else if (command.image == "sky") {
    write(draw_sky_transfer(bake, command.index), command.output);
  } else if (command.image == "environment") {
    write(draw_environment(bake, command.environment), command.output);
  } else if (command.image == "curves") {
    const std::string svg = draw_curves(bake);
    write_file_atomically(command.output, std::as_bytes(std::span(svg)));
  } else if (command.image == "clusters") {
    const auto artifact = bake.artifact("samples");
    const auto roots = artifact->has("root") ? artifact->vector<std::uint32_t>("root")
                                             : std::vector<std::uint32_t>{};
    write(draw_clusters(get_samples(*artifact), roots), command.output);
  } else {
    const SampleSet samples = get_samples(*bake.artifact("samples"));
    const ClusterValues values = values_of(command.image, bake, samples.clusters());
    Drawing drawing = draw_values(samples, values);
    draw_legend(drawing, values);
    write(drawing, command.output);
    out += fmt::format("{}: from {} to {}\n", values.title, values.text(values.low),
                       values.text(values.high));
  }
}

}  // namespace

ExitCode inspect(const InspectCommand& command, std::string& out) {
  PosixFileSystem disk;
  if (command.watch) {
    watch_bake(disk, command.bake, stdout, isatty(STDOUT_FILENO) != 0);
    return ExitCode::kDone;
  }
  const BakeReader bake(disk, command.bake);
  if (!command.image.empty()) {
    draw_image(command, bake, out);
    return ExitCode::kDone;
  }
  const BakeTables tables = make_tables(bake);
  nlohmann::json report = to_json(tables);
  if (!command.json) out += to_text(tables);
  ExitCode code = ExitCode::kDone;
  if (command.verify) {
    const Verification verification = verify_bake(bake);
    if (!verification.unsound.empty()) code = ExitCode::kUnsound;
    report["verification"] = to_json(verification);
    if (!command.json) out += "\n" + to_text(verification);
  }
  if (command.json) out += report.dump(2) + "\n";
  return code;
}

}  // namespace prt
