// What report.html shows of a bake: the relit room, and clusters, ranks and errors in false colour.
#pragma once

#include "apps/bake/report_pictures.h"

namespace prt {

DrawReportPictures make_report_pictures();

}  // namespace prt
