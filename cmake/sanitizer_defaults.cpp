// Linked into every program of a sanitizer build: what Open MPI, TBB and Mesa do themselves is not
// our report. It is built in, so that it holds however a program is started.

/// Libraries stay mapped until the end: a leak's stack in an unloaded plug-in could not be named.
extern "C" int dlclose(void* /*handle*/) { return 0; }

extern "C" const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "leak:libopen-pal\n"
         "leak:libopen-rte\n"
         "leak:libmpi\n"
         "leak:libpmix\n"
         "leak:libhwloc\n"
         "leak:libevent\n"
         "leak:libpsm_infinipath\n"
         "leak:libpsm2\n"
         "leak:libfabric\n"
         "leak:libucp\n"
         "leak:libtbb\n"
         "leak:swrast_dri\n"
         "leak:libLLVM\n"
         "leak:libEGL\n"
         "leak:libX11\n"
         "leak:mca_\n";
}

// TBB and Open MPI synchronise by means that the thread sanitizer does not see. (Open MPI calls
// nothing of ours back.)
extern "C" const char* __tsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "race_top:tbb::\n"
         "race_top:start_for\n"
         "race_top:std::__atomic_base\n"
         "race_top:oneapi/tbb\n"
         "race:libevent\n"
         "race:libopen-\n"
         "race:libpmix\n"
         "race:libmpi.so\n"
         "race:openmpi/\n"
         "mutex:libevent\n"
         "mutex:libpmix\n"
         "mutex:openmpi/\n"
         "deadlock:libevent\n"
         "deadlock:libpmix\n"
         "deadlock:libopen-\n"
         "deadlock:openmpi/\n"
         "called_from_lib:libmpi.so\n"
         "called_from_lib:libopen-pal\n"
         "called_from_lib:libopen-rte\n"
         "called_from_lib:libpmix\n";
}
