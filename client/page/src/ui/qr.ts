import qrcode from "qrcode-generator";

import {make} from "./elements";
import {setWords} from "./spoken";

const kQuiet = 4; // margin in modules, as the standard requires

/// Draws a text as a QR code, dark on light in every theme, because not all readers
/// accept the inverse.
export function qrSvg(text: string, label: () => string): Element {
  const code = qrcode(0, "M"); // the smallest size that holds the text
  code.addData(text, "Byte");
  code.make();
  const holder = make("div");
  holder.innerHTML = code.createSvgTag({cellSize: 1, margin: kQuiet, scalable: true});
  const svg = holder.firstElementChild!;
  svg.setAttribute("role", "img");
  svg.setAttribute("shape-rendering", "crispEdges");
  setWords(svg, "ariaLabel", label);
  return svg;
}
