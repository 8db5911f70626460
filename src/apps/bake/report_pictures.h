// Pictures that a finished bake shows in its report.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/bake/history.h"
#include "package/package.h"

namespace prt {

struct ReportPicture {
  std::string title;
  std::string caption;
  std::string jpeg;       ///< bytes of the file
  std::string low, high;  ///< ends of the colour scale; empty: there is none
};

using DrawReportPictures = std::function<std::vector<ReportPicture>(
    const Package& package,
    const std::function<std::shared_ptr<const Artifact>(const std::string& task)>& result,
    const std::vector<TaskHistory>& tasks)>;

}  // namespace prt
