import {say} from "../messages/say";
import {kQualities, type PictureQuality, qualityOf, qualityWords} from "../model/quality";
import {rememberInAddress} from "./address";
import {element, option, setText} from "./elements";
import {followLanguage} from "./spoken";

/// Shows the pictures' quality, and lets the reader fix it.
export class QualityPick {
  private readonly select = element("quality", HTMLSelectElement);
  private readonly words = element("quality-words", HTMLParagraphElement);

  constructor(
    private readonly quality: PictureQuality,
    changed: () => void,
  ) {
    this.select.add(option(() => say("quality.by_pace"), ""));
    for (const name of kQualities)
      this.select.add(option(() => say(`quality.always_${name}`), name));
    this.select.value = quality.fixed ?? "";
    this.select.addEventListener("change", () => {
      quality.fixed = qualityOf(this.select.value);
      rememberInAddress("quality", this.select.value);
      this.show();
      changed();
    });
    this.show();
    followLanguage(() => this.show());
  }

  show(): void {
    setText(this.words, qualityWords(this.quality));
  }
}
