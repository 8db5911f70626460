#include "apps/inspect/inspect.h"

#include <unistd.h>

#include <cstdio>

#include "apps/inspect/clusters_image.h"
#include "apps/inspect/depth_image.h"
#include "apps/inspect/tables.h"
#include "apps/inspect/verify.h"
#include "apps/inspect/watch.h"
#include "base/image_file.h"
#include "store/samples_io.h"

namespace prt {

namespace {

void write(const Picture& picture, const std::filesystem::path& path) {
  write_png(path, picture.width(), picture.height(), picture.rgb());
}

void draw_image(const InspectCommand& command, const BakeReader& bake) {
  if (command.image == "clusters") {
    const auto artifact = bake.artifact("samples");
    const auto roots = artifact->has("root") ? artifact->vector<std::uint32_t>("root")
                                             : std::vector<std::uint32_t>{};
    write(draw_clusters(get_samples(*artifact), roots), command.output);
  } else {
    write(draw_depth(bake, command.cluster, command.index), command.output);
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
    draw_image(command, bake);
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
