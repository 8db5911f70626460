#include "apps/prt_eval_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "apps/program.h"
#include "base/error.h"
#include "scene/environment.h"

namespace prt {
namespace {

/// What the parser fills in, before it is checked as a whole.
struct Words {
  std::string package, reference, points, output, json, pictures;
  std::vector<std::string> lights, environments;
  float clearance = 0.0F;
};

[[noreturn]] void refuse(const std::string& why) {
  throw UserError("command line: " + why + "; prt_eval --help shows the four forms");
}

/// Options that belong to one form only are refused in the others rather than ignored.
void check_form(const CLI::App& app, const Words& words) {
  const auto given = [&](const char* option) { return app.count(option) > 0; };
  if (words.package.empty() == words.reference.empty()) {
    refuse("give either a package or --reference SCENE");
  }
  if (!words.reference.empty() && words.points.empty())
    refuse("--reference needs --points FILE.csv");
  if (words.points.empty()) {
    for (const char* option : {"--light", "--output"}) {
      if (given(option)) refuse(std::string(option) + " needs --points FILE.csv");
    }
    if (words.environments.empty()) return;
    for (const char* option : {"--lights", "--clearance", "--pictures"}) {
      if (given(option)) refuse(std::string(option) + " does not go with --env");
    }
    return;
  }
  if (words.output.empty()) refuse("--points needs -o OUT.csv");
  if (words.lights.empty() && words.environments.empty()) {
    refuse("--points needs at least one --light SPEC or an --env SPEC");
  }
  if (words.environments.size() > 1) refuse("--points takes one --env SPEC");
  for (const char* option : {"--lights", "--clearance", "--json", "--pictures"}) {
    if (given(option)) refuse(std::string(option) + " does not go with --points");
  }
  if (words.reference.empty()) {
    for (const char* option : {"--spp", "--seed"}) {
      if (given(option)) refuse(std::string(option) + " has no use here: nothing is path traced");
    }
  }
}

}  // namespace

std::optional<EvalCommand> parse_eval_command(int argc, char** argv, std::string& message) {
  EvalCommand command;
  Words words;
  CLI::App app{"Says how wrong a package is: its error against a path-traced reference.",
               "prt_eval"};
  app.add_option("PACKAGE", words.package, "runtime package (.prt.glb)");
  app.add_option("--lights", command.lights, "test lights")
      ->check(CLI::Range(1, 100'000))
      ->type_name("N");
  app.add_option("--seed", command.seed, "seed of test lights, test points and paths")
      ->type_name("S");
  app.add_option("--spp", command.paths, "paths per point and light")
      ->check(CLI::Range(2, 1'000'000))
      ->type_name("N");
  auto* clearance = app.add_option("--clearance", words.clearance,
                                   "distance of test lights from every surface, m (default: 2 % of "
                                   "the samples' diagonal)")
                        ->check(finite_number())
                        ->check(CLI::NonNegativeNumber)
                        ->type_name("M");
  app.add_option("--json", words.json, "write the figures as JSON; - for standard output")
      ->type_name("FILE");
  app.add_option("--pictures", words.pictures,
                 "write a picture per test light into this folder: error of direct (left) and "
                 "indirect light (right) over its mean, red too bright, blue too dark")
      ->type_name("DIR");
  app.add_option(
         "--points", words.points,
         "points x,y,z,nx,ny,nz at which irradiance is asked for, in the scene file's world, m")
      ->type_name("FILE.csv");
  app.add_option("--light", words.lights,
                 "a light: point:x,y,z:r,g,b | sphere:x,y,z:r,g,b:radius | "
                 "spot:x,y,z:dx,dy,dz:r,g,b:inner_deg,outer_deg | "
                 "quad:cx,cy,cz:ux,uy,uz:vx,vy,vz:r,g,b | sun:dx,dy,dz:r,g,b; places in the scene "
                 "file's world, m")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("SPEC");
  app.add_option("--env", words.environments, std::string("an environment: ") + kEnvironmentForms)
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("SPEC");
  app.add_option("--reference", words.reference, "path trace this scene (.glb or .gltf)")
      ->type_name("SCENE");
  app.add_option("-o,--output", words.output, "points with their irradiance, W/m²")
      ->type_name("OUT.csv");
  app.footer(
      "Four forms:\n"
      "  prt_eval PACKAGE [--lights N] [--seed S] [--spp N] [--clearance M] [--json FILE] "
      "[--pictures DIR]\n"
      "  prt_eval PACKAGE --env SPEC... [--seed S] [--spp N] [--json FILE]\n"
      "  prt_eval PACKAGE --points FILE.csv --light SPEC... [--env SPEC] -o OUT.csv\n"
      "  prt_eval --reference SCENE --points FILE.csv --light SPEC... [--env SPEC] [--spp N] "
      "[--seed S] -o "
      "OUT.csv\n"
      "Exit codes: 0 done, 2 bad command line or input, 1 anything else.");
  if (!parse_arguments(app, argc, argv, message)) return std::nullopt;
  check_form(app, words);
  using Form = EvalCommand::Form;
  command.environments = words.environments;
  if (words.points.empty()) {
    command.form = words.environments.empty() ? Form::kError : Form::kSkyError;
  } else {
    command.form = words.reference.empty() ? Form::kPlayPoints : Form::kTracePoints;
  }
  command.input = words.reference.empty() ? words.package : words.reference;
  if (clearance->count() > 0) command.clearance = words.clearance;
  command.json = words.json;
  command.pictures = words.pictures;
  command.points = words.points;
  command.output = words.output;
  for (const std::string& spec : words.lights) command.point_lights.push_back(parse_light(spec));
  return command;
}

}  // namespace prt
