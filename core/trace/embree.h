// Embree 3 and Embree 4 behind one interface: their headers and how a query is made. Only
// core/trace and its tests include this; CMakeLists.txt, which finds the library, defines
// REKINDLE_EMBREE for them. Embree 4 moved the flags of a query from its context to arguments of
// its own; what filter functions need is the geometry's user data, which both have. Nothing else in
// use differs.
#pragma once

#ifndef REKINDLE_EMBREE
#error "CMakeLists.txt defines REKINDLE_EMBREE for the files that include this: add yours"
#elif REKINDLE_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace core {

/// How rays are asked about: made once for many rays, by each thread its own.
class EmbreeQuery {
public:
    /// `coherent`: neighbours in a packet go much the same way, which is faster if true.
    explicit EmbreeQuery(bool coherent = false)
    {
#if REKINDLE_EMBREE >= 4
        rtcInitRayQueryContext(&context_);
        rtcInitIntersectArguments(&closest_);
        rtcInitOccludedArguments(&any_);
        closest_.context = any_.context = &context_;
        closest_.flags = any_.flags =
            coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
#else
        rtcInitIntersectContext(&context_);
        context_.flags =
            coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
#endif
    }
    EmbreeQuery(const EmbreeQuery&) = delete;  // holds pointers into itself
    EmbreeQuery& operator=(const EmbreeQuery&) = delete;

#if REKINDLE_EMBREE >= 4
    void closest(RTCScene scene, RTCRayHit& r)
    {
        rtcIntersect1(scene, &r, &closest_);
    }
    void any(RTCScene scene, RTCRay& r)
    {
        rtcOccluded1(scene, &r, &any_);
    }
    void closest(const int* valid, RTCScene scene, RTCRayHit16& r)
    {
        rtcIntersect16(valid, scene, &r, &closest_);
    }
    void any(const int* valid, RTCScene scene, RTCRay16& r)
    {
        rtcOccluded16(valid, scene, &r, &any_);
    }

private:
    RTCRayQueryContext context_;
    RTCIntersectArguments closest_;
    RTCOccludedArguments any_;
#else
    /// Fills in `r.hit` and the distance of the nearest hit; geomID stays invalid without one.
    void closest(RTCScene scene, RTCRayHit& r)
    {
        rtcIntersect1(scene, &context_, &r);
    }
    /// Sets `r.tfar` to minus infinity when something is hit.
    void any(RTCScene scene, RTCRay& r)
    {
        rtcOccluded1(scene, &context_, &r);
    }
    /// The same for the lanes of a packet whose `valid` is -1.
    void closest(const int* valid, RTCScene scene, RTCRayHit16& r)
    {
        rtcIntersect16(valid, scene, &context_, &r);
    }
    void any(const int* valid, RTCScene scene, RTCRay16& r)
    {
        rtcOccluded16(valid, scene, &context_, &r);
    }

private:
    RTCIntersectContext context_;
#endif
};

}  // namespace core
