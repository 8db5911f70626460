// All that differs between Embree 3 and Embree 4. Internal to scene/embree/.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <type_traits>

namespace prt {

/// Called for every hit that the filter of its geometry lets pass.
using QueryFilter = void (*)(const RTCFilterFunctionNArguments*);

#if RTC_VERSION_MAJOR >= 4

inline const auto kSceneFlags =
    static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS);

/// Begins with what Embree hands to filters, so that query_of() finds it again.
struct Query {
  RTCRayQueryContext context;
  RTCIntersectArguments intersect;
  RTCOccludedArguments occluded;

  explicit Query(bool coherent, QueryFilter filter = nullptr) {
    int flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    if (filter != nullptr) flags |= RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    rtcInitRayQueryContext(&context);
    rtcInitIntersectArguments(&intersect);
    rtcInitOccludedArguments(&occluded);
    intersect.flags = occluded.flags = static_cast<RTCRayQueryFlags>(flags);
    intersect.context = occluded.context = &context;
    intersect.filter = filter;
  }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;
};
inline void embree_intersect1(RTCScene scene, Query& query, RTCRayHit& ray) {
  rtcIntersect1(scene, &ray, &query.intersect);
}
inline void embree_intersect16(const int* valid, RTCScene scene, Query& query, RTCRayHit16& rays) {
  rtcIntersect16(valid, scene, &rays, &query.intersect);
}
inline void embree_occluded16(const int* valid, RTCScene scene, Query& query, RTCRay16& rays) {
  rtcOccluded16(valid, scene, &rays, &query.occluded);
}

#else

inline const auto kSceneFlags =
    static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);

/// Begins with what Embree hands to filters, so that query_of() finds it again.
struct Query {
  RTCIntersectContext context;

  explicit Query(bool coherent, QueryFilter filter = nullptr) {
    rtcInitIntersectContext(&context);
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    context.filter = filter;
  }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;
};
inline void embree_intersect1(RTCScene scene, Query& query, RTCRayHit& ray) {
  rtcIntersect1(scene, &query.context, &ray);
}
inline void embree_intersect16(const int* valid, RTCScene scene, Query& query, RTCRayHit16& rays) {
  rtcIntersect16(valid, scene, &query.context, &rays);
}
inline void embree_occluded16(const int* valid, RTCScene scene, Query& query, RTCRay16& rays) {
  rtcOccluded16(valid, scene, &query.context, &rays);
}

#endif

/// The query whose filter was called.
inline Query* query_of(const RTCFilterFunctionNArguments* arguments) {
  static_assert(std::is_standard_layout_v<Query>, "a query and its first member share an address");
  return reinterpret_cast<Query*>(arguments->context);
}

}  // namespace prt
