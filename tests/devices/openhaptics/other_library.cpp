// Stands for libPHANToMIO, which the vendor's library needs; and for a library that is another one.
extern "C" unsigned hdInitDevice(const char*) {
  return 0;
}
