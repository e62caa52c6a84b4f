// CHAI3D's meshes may carry pictures, whose formats need further libraries.  Nothing here has any,
// so these stand in for what would read and write them.
#include <string>

namespace chai3d {

class cImage;

#define PALPATE_NO_PICTURE(function)                         \
  bool function(cImage* image, const std::string& filename); \
  bool function(cImage*, const std::string&) {               \
    return false;                                            \
  }

PALPATE_NO_PICTURE(cLoadFileBMP)
PALPATE_NO_PICTURE(cLoadFileGIF)
PALPATE_NO_PICTURE(cLoadFileJPG)
PALPATE_NO_PICTURE(cLoadFilePNG)
PALPATE_NO_PICTURE(cLoadFilePPM)
PALPATE_NO_PICTURE(cLoadFileRAW)
PALPATE_NO_PICTURE(cLoadFileSTB)
PALPATE_NO_PICTURE(cSaveFileBMP)
PALPATE_NO_PICTURE(cSaveFileGIF)
PALPATE_NO_PICTURE(cSaveFileJPG)
PALPATE_NO_PICTURE(cSaveFilePNG)
PALPATE_NO_PICTURE(cSaveFilePPM)
PALPATE_NO_PICTURE(cSaveFileRAW)

}  // namespace chai3d
