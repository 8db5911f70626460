#include "apps/prt_bake_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/inspect/clusters_image.h"
#include "base/image_file.h"
#include "player/environment_light.h"
#include "player/picture.h"
#include "player/set_up.h"

namespace prt {

namespace {

constexpr int kWidth = 720, kHeight = 480;
constexpr int kQuality = 85;

std::string jpeg_of(const Evaluator& evaluator, const SampleIrradiance& irradiance,
                    const Environment* environment) {
  PictureSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  settings.environment = environment;
  const Picture picture = render(evaluator, irradiance, default_camera(evaluator), settings);
  return encode_jpeg(picture.width, picture.height, picture.rgb, kQuality);
}

ReportPicture relit(const Package& package) {
  const Evaluator evaluator(package);
  std::vector<Light> lights;
  for (const SceneLight& light : package.scene.lights) lights.push_back(to_light(light));
  const bool own = !lights.empty();
  if (!own) lights.push_back(default_light(evaluator));
  return {"The room, played from the package",
          own ? "under the scene's own lights" : "under a point light in the middle of the scene",
          jpeg_of(evaluator, evaluator.evaluate(lights), nullptr), "", ""};
}

ReportPicture under_a_sky(const Package& package) {
  const Evaluator evaluator(package);
  const Environment sky = default_environment();
  const MatrixF coefficients = EnvironmentLight(sky, environment_order(package)).coefficients();
  return {"The scene, played from the package", "under a clear sky",
          jpeg_of(evaluator, evaluator.evaluate({}, coefficients), &sky), "", ""};
}

std::string jpeg_of(const Drawing& drawing) {
  return encode_jpeg(drawing.width(), drawing.height(), drawing.rgb(), kQuality);
}

ReportPicture false_colour(const SampleSet& samples, const ClusterValues& values,
                           const std::string& title) {
  return {title, values.title, jpeg_of(draw_values(samples, values, kWidth, kHeight)),
          values.text(values.low), values.text(values.high)};
}

/// Measured error of each cluster's transfer; the last round's where there were several.
ClusterValues errors_of(const std::vector<TaskHistory>& tasks, std::size_t clusters) {
  std::vector<double> errors(clusters, std::numeric_limits<double>::quiet_NaN());
  for (const TaskHistory& task : tasks) {
    if (task.stage != "transfer" && task.stage != "photon_transfer") continue;
    const auto cluster = task.figures.value("cluster", std::size_t{clusters});
    if (cluster < clusters) errors[cluster] = task.figures.value("error", errors[cluster]);
  }
  return transfer_errors(std::move(errors));
}

bool any_known(const ClusterValues& values) {
  return std::ranges::any_of(values.of_cluster, [](double v) { return std::isfinite(v); });
}

}  // namespace

DrawReportPictures make_report_pictures() {
  return [](const Package& package, const auto& result, const std::vector<TaskHistory>& tasks) {
    const SampleSet& samples = package.samples;
    std::vector<ReportPicture> pictures;
    if (has_direct_light(package)) pictures.push_back(relit(package));
    if (environment_order(package) > 0) pictures.push_back(under_a_sky(package));
    pictures.push_back(
        {"Clusters", fmt::format("{} samples in {} clusters", samples.size(), samples.clusters()),
         jpeg_of(draw_clusters(samples, {}, kWidth, kHeight)), "", ""});
    if (const auto functions = result("light_functions")) {
      pictures.push_back(false_colour(samples, light_function_counts(*functions), "Ranks"));
    }
    const ClusterValues errors = errors_of(tasks, samples.clusters());
    if (any_known(errors)) pictures.push_back(false_colour(samples, errors, "Errors"));
    return pictures;
  };
}

}  // namespace prt
