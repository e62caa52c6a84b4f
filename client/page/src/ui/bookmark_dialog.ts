import {say} from "../messages/say";
import {clock, fitBytes} from "../model/words";
import {element, onPress, setTextOf} from "./elements";
import {setWords} from "./spoken";

/// client/replayer/play/bookmarks.h [bytes]
const kLongestName = 100;

/// The dialog in which a bookmark gets its name.
export class BookmarkDialog {
  private readonly dialog = element("bookmark-dialog", HTMLDialogElement);
  private readonly name = element("bookmark-name", HTMLInputElement);
  private atS = 0;

  constructor(keep: (atS: number, name: string) => void) {
    onPress("bookmark-cancel", () => this.close());
    this.name.addEventListener("input", (event) => {
      // An unfinished input of an input method is left alone.
      if (event instanceof InputEvent && event.isComposing) return;
      const fit = fitBytes(this.name.value, kLongestName);
      if (fit !== this.name.value) this.name.value = fit;
    });
    this.dialog.addEventListener("close", () => {
      this.name.blur();
      if (this.dialog.returnValue !== "keep") return;
      const text = fitBytes(this.name.value.trim(), kLongestName);
      keep(this.atS, text || this.name.placeholder);
    });
  }

  /// @param atS  where the bookmark is to be
  open(atS: number): void {
    if (this.dialog.open) return;
    this.atS = atS;
    const at = clock(atS);
    setTextOf("bookmark-title", () => say("bookmark.title_at", {at}));
    this.name.value = "";
    setWords(this.name, "placeholder", () => say("bookmark.default", {at}));
    this.dialog.returnValue = "";
    this.dialog.showModal();
    this.name.focus();
  }
  close(): void {
    if (this.dialog.open) this.dialog.close("");
  }
}
