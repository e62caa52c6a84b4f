// Stands in for libPHANToMIO, which the vendor's library needs, and for a library of another kind.
extern "C" unsigned hdInitDevice(const char*) {
  return 0;
}
