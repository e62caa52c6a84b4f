/* first_force.cpp, in C11: a ball is pressed 3 mm into a block. */
#include <palpate.h>
#include <stdio.h>

int main(void) {
  const double size_m[3] = {0.04, 0.04, 0.04};
  palpate_scene* scene = palpate_scene_new(PALPATE_SURFACE);
  if (palpate_scene_add_box(scene, PALPATE_OBJECT, "block", size_m, NULL) != 0 ||
      palpate_scene_add_ball(scene, PALPATE_TOOL, "ball", 0.005, NULL) != 0) {
    fprintf(stderr, "%s\n", palpate_last_error());
    return 1;
  }
  palpate_model* model = palpate_model_new(scene, 0);
  palpate_pose hand = {{0.0, 0.030, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  palpate_proxy* proxy = palpate_proxy_new(model, &hand);
  if (proxy == NULL) {
    fprintf(stderr, "%s\n", palpate_last_error());
    return 1;
  }
  palpate_report report;
  for (int ms = 0; ms < 1000; ++ms) {
    hand.position_m[1] -= 8e-6;
    palpate_proxy_step(proxy, &hand, &report);
  }
  printf("hand at %.1f mm, ball at %.1f mm, force %.2f N\n", 1e3 * hand.position_m[1],
         1e3 * report.tool.position_m[1], report.force_N[1]);
  palpate_proxy_free(proxy);
  palpate_model_free(model);
  palpate_scene_free(scene);
  return 0;
}
