extern "C" unsigned hdInitDevice(const char*);

unsigned OpenAnArm() {
  return hdInitDevice(nullptr);
}
