// From candidates to points: in one task, or where candidates are many in tiles of space, so that
// no task reads or thins all of them, as long as the surface that light can reach is spread like
// the scene's own: tiles are cut by that.
//
//   candidates ─► tiles (a group of candidate tasks × a group of tiles) ─► highest (a tile each)
//       ─► spacing ─► thin (a tile each) ─► points
//
// Which points come out does not depend on it: see domains/thinning.h.
#pragma once

#include <string>
#include <vector>

#include "methods/method.h"

namespace prt {

/// How thinning is divided, by numbers of items alone.
struct ThinningSplit {
  double candidates_per_tile = 4e6;
  std::size_t parts_per_group = 24;  ///< candidate tasks whose points one task sorts into tiles
  std::size_t tiles_per_group = 8;   ///< tiles that it sorts them into
  /// 1: one task thins all.
  [[nodiscard]] std::size_t tiles(double candidates) const;
};

/// What thinning has to do.
struct ThinningSize {
  double candidates = 0.0;  ///< about
  float spacing = 0.0F;     ///< at most, m
};

/// Adds the tasks that lead from those of the candidates to "points".
void plan_points(const PlanInputs& inputs, const std::vector<TaskSpec>& candidates,
                 const ThinningSize& size, const ThinningSplit& split, Plan& plan);

std::vector<std::string> thinning_kinds();
Artifact run_thinning(const TaskSpec& task, const TaskReader& reader);

}  // namespace prt
