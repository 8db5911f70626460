// prt_bake: bakes a scene's light transport on any number of MPI ranks.
#include "apps/bake/bake.h"
#include "apps/prt_bake_evaluator.h"
#include "apps/prt_bake_pictures.h"
#include "package/write.h"
#include "scene/embree/embree_ray_caster.h"
#include "scene/load.h"

int main(int argc, char** argv) {
  prt::BakeProgram program{prt::all_methods(),   prt::make_bake_evaluator(),
                           prt::load_scene,      prt::make_embree_ray_caster,
                           prt::best_embree_isa, prt::encode_package};
  program.draw_pictures = prt::make_report_pictures();
  return prt::bake_main(argc, argv, program);
}
