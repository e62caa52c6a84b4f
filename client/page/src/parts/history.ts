import {keep, recall} from "../base/kept";
import {locale, say, type Words} from "../messages/say";
import {
  type ClassHistory,
  fetchHistory,
  type PersonHistory,
  saveHistory,
} from "../protocol/history_messages";
import {make, option, press, setText} from "../ui/elements";
import {HistoryClass} from "../ui/history_class";
import {personHistory} from "../ui/history_person";
import {Room} from "../ui/room";
import {followLanguage} from "../ui/spoken";

export interface HistoryEvents {
  headers(): Record<string, string>;
  /// Number of this page's person; 0: none.
  me(): number;
  /// Deletes all data of a person; `done` is given the refusal, or "".
  remove(person: number, done: (refusal: Words) => void): void;
}

/// An open page follows later changes.
const kAskAgainS = 10;

/// How a CSV is written (CsvAs): endings of its address, with the separator and a number.
const kCsvForms = [
  {as: ".csv", separator: ",", number: "0.5"},
  {as: ".semicolon.csv", separator: ";", number: "0.5"},
  {as: ".comma.csv", separator: ";", number: "0,5"},
] as const;
const kCsvKey = "palpate-csv";

/// What spreadsheets of the reader's region expect: commas separate only where numbers have none,
/// and nowhere in Switzerland.
function usualCsv(): string {
  const language = (of: string): string | undefined => of.split("-")[0];
  const {language: own} = navigator;
  const region = language(own) === language(locale()) ? own : locale();
  if (/-(CH|LI)$/.test(region)) return ".semicolon.csv";
  return (0.5).toLocaleString(region).includes(",") ? ".comma.csv" : ".csv";
}

/// The trials so far: a class's for teachers, and each person's own.
export class HistoryRoom {
  private readonly room = new Room(
    "history",
    {open: "history.open", openTitle: "history.open_title", title: "history.title"},
    () => this.open(),
  );
  private readonly back = press("history.back", () => this.turn(0));
  private readonly csv = press("history.csv", () => void this.save("csv"));
  private readonly csvAs = make("select.csv-as", {sayLabel: "history.csv_as"});
  private readonly zip = press("history.zip", () => void this.save("zip"));
  private readonly remove = press("history.delete", () => this.ask());
  private readonly question = make("section.question", {role: "alert", hidden: true});
  private readonly ofClass: HistoryClass;
  private readonly ofPerson = make("div.of-person");
  private teaches = false;
  private person = 0; // the person shown; 0: the class
  private name = "";
  private shown = "";
  private found: PersonHistory | undefined; // as it is drawn
  private askedS = -Infinity;

  constructor(private readonly events: HistoryEvents) {
    this.ofClass = new HistoryClass((person) => this.turn(person));
    this.csvAs.append(
      ...kCsvForms.map(({as, ...form}) => option(() => say("history.csv_form", form), as)),
    );
    this.csvAs.addEventListener("change", () => keep("localStorage", kCsvKey, this.csvAs.value));
    const files = make("span.choices.files", this.csv, this.csvAs, this.zip, this.remove);
    const body = [this.question, this.ofClass.body, this.ofPerson];
    this.room.fill({before: this.back, after: [files]}, ...body);
    followLanguage(() => {
      if (this.found) this.drawPerson(this.found);
    });
  }

  /// @param own      this page is a person's who may do exercises
  /// @param teaches  it may see everybody's
  allow(own: boolean, teaches: boolean): void {
    this.teaches = teaches;
    this.room.allow(own || teaches);
  }

  tick(nowS: number): void {
    if (!this.room.isOpen || nowS - this.askedS < kAskAgainS) return;
    this.askedS = nowS;
    void this.load();
  }

  private open(): void {
    this.csvAs.value = recall("localStorage", kCsvKey) ?? usualCsv();
    this.turn(this.teaches ? 0 : this.events.me());
    this.room.open();
  }

  private turn(person: number): void {
    this.person = person;
    this.shown = "";
    this.found = undefined;
    this.askedS = -Infinity;
    this.room.tell("");
    this.question.hidden = true;
    const isClass = person === 0;
    this.ofClass.body.hidden = this.ofPerson.hidden = true;
    this.back.hidden = isClass || !this.teaches;
    this.zip.hidden = isClass;
    this.remove.hidden = isClass || !this.teaches;
    setText(this.room.title, () => say(isClass ? "history.class_title" : "history.title"));
    this.room.dialog.scrollTop = 0;
  }

  private async load(): Promise<void> {
    const {person} = this;
    const of = person === 0 ? "class" : String(person);
    const found = await fetchHistory<ClassHistory | PersonHistory>(of, this.events.headers());
    if (person !== this.person) return; // another one has been chosen meanwhile
    if (!found) return this.room.tell(() => say("history.not_had"), true);
    const now = JSON.stringify(found);
    if (now === this.shown) return; // unchanged: what somebody reads stays
    this.shown = now;
    const isClass = "people" in found;
    this.ofClass.body.hidden = !isClass;
    this.ofPerson.hidden = isClass;
    if (isClass) this.ofClass.show(found);
    else this.drawPerson(found);
  }

  private drawPerson(found: PersonHistory): void {
    this.found = found;
    this.name = found.name;
    const isOwn = this.person === this.events.me();
    setText(this.room.title, isOwn ? () => say("history.title") : found.name);
    const open = [...this.ofPerson.querySelectorAll("details")].map((one) => one.open);
    this.ofPerson.replaceChildren(...personHistory(found, isOwn));
    this.ofPerson.querySelectorAll("details").forEach((one, i) => (one.open = open[i] ?? false));
  }

  private async save(as: "csv" | "zip"): Promise<void> {
    const of = this.person === 0 ? "class" : String(this.person);
    this.room.tell(() => say("history.wait"));
    const name = `palpate-${this.person === 0 ? "class" : this.name}.${as}`;
    const file = as === "csv" ? `${of}${this.csvAs.value}` : `${of}.${as}`;
    const had = await saveHistory(file, name, this.events.headers());
    this.room.tell(had ? "" : () => say("history.not_had"), !had);
  }

  /// Asks twice: deletion cannot be undone.
  private ask(): void {
    const {name} = this;
    const put = (words: () => string, ...choices: HTMLButtonElement[]): void => {
      const spare = press("history.keep", () => {
        this.question.hidden = true;
        this.remove.focus();
      });
      this.question.replaceChildren(make("p", words), make("p.choices", spare, ...choices));
      this.question.hidden = false;
      spare.focus();
    };
    const alarm = (button: HTMLButtonElement): HTMLButtonElement =>
      Object.assign(button, {className: "alarm"});
    const again = (): void =>
      put(
        () => say("history.sure", {name}),
        alarm(press("history.for_good", () => this.removeNow())),
      );
    put(() => say("history.deletes", {name}), alarm(press("history.yes", again)));
  }

  private removeNow(): void {
    this.question.hidden = true;
    const {name} = this;
    this.events.remove(this.person, (refusal) => {
      if (refusal !== "") return this.room.tell(refusal, true);
      this.turn(0);
      this.room.tell(() => say("history.deleted", {name}));
    });
  }
}
