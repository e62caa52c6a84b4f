import {say, sayNumber} from "../messages/say";
import type {
  ClassHistory,
  DoneSeries,
  HistoryExercise,
  HistoryPerson,
} from "../protocol/history_messages";
import {Curve, legend, lossBars} from "./curve";
import {make, setOptions, table} from "./elements";
import {criterionName, gradeFigure, gradeWords, namedLosses, titlesOf} from "./history_words";
import {followLanguage} from "./spoken";

interface Row {
  readonly person: HistoryPerson;
  readonly did: DoneSeries | undefined;
}

/// A class in one exercise: its spread, its costliest criteria, and everybody's grade.
export class HistoryClass {
  readonly body = make("div.of-class");
  private readonly pick = make("select", {id: "history-exercise"});
  private readonly curve = new Curve();
  private readonly losses = make("div");
  private readonly everybody = make("div.table", {
    ...{tabIndex: 0, role: "region", sayLabel: "history.everybody"},
  });
  private readonly none = make("p.quiet", {say: "history.none"});
  private readonly figures: HTMLElement;
  private history: ClassHistory = {exercises: [], people: []};
  private byGrade = false;

  constructor(private readonly open: (person: number) => void) {
    this.pick.addEventListener("change", () => this.draw());
    const label = make(
      "label",
      {htmlFor: this.pick.id},
      () => `${say("history.exercise")} `,
      this.pick,
    );
    const spread = make(
      "section",
      make("h3", {say: "history.points_over_trials"}),
      this.curve.body,
      legend(
        ["band", () => say("history.half")],
        ["median", () => say("history.median")],
        ["other", () => say("history.each")],
        ["pass", () => say("history.pass")],
      ),
    );
    const lost = make("section", make("h3", {say: "history.class_loses"}), this.losses);
    this.figures = make(
      "div",
      make("p.pick-exercise", label),
      make("div.side-by-side", spread, lost),
      this.everybody,
    );
    this.body.append(this.none, this.figures);
    followLanguage(() => {
      if (this.history.people.length > 0) this.show(this.history);
    });
  }

  show(history: ClassHistory): void {
    this.history = history;
    const titles = titlesOf(history.exercises);
    const options = [...titles].map(([value, text]) => ({value, text}));
    const chosen = titles.has(this.pick.value) ? this.pick.value : (options[0]?.value ?? "");
    setOptions(this.pick, options, chosen, say("history.none"));
    this.draw();
  }

  private draw(): void {
    const {people, exercises} = this.history;
    const exercise = exercises.find(({name}) => name === this.pick.value);
    this.none.hidden = people.length > 0;
    this.figures.hidden = people.length === 0;
    const rows: Row[] = people.map((person) => ({
      person,
      did: person.did.find((one) => one.exercise === exercise?.name),
    }));
    this.curve.show({
      label: say("history.class_curve", {people: rows.filter(({did}) => did).length}),
      spread: exercise?.spread ?? [],
      pass: exercise?.pass ?? null,
      own: [],
      others: rows.flatMap(({person, did}) =>
        did && person.role !== "operate" ? [{key: person.person, points: did.points}] : [],
      ),
    });
    this.losses.replaceChildren(
      lossBars(exercise ? namedLosses(exercise) : [], say("history.class_loses")),
    );
    const heads = [
      ...[this.sorter("history.person", false), this.sorter("history.grade", true)],
      ...(["history.trials", "history.costs_most"] as const).map((key) =>
        make("th.wide", {scope: "col"}, say(key)),
      ),
    ];
    const rank = ({did}: Row): number => did?.grade.mean ?? Infinity;
    rows.sort(
      (a, b) =>
        Number(b.person.here) - Number(a.person.here) ||
        (this.byGrade ? rank(a) - rank(b) || 0 : 0) ||
        a.person.name.localeCompare(b.person.name),
    );
    const all = rows.map((row) => this.rowOf(row, exercise));
    this.everybody.replaceChildren(table(heads, all));
  }

  private sorter(word: "history.person" | "history.grade", byGrade: boolean): HTMLElement {
    const isSorted = this.byGrade === byGrade;
    const press = make("button", {
      ...{type: "button", className: "sort", textContent: say(word)},
      onclick: () => {
        this.byGrade = byGrade;
        this.draw();
        this.everybody.querySelectorAll<HTMLElement>("button.sort")[byGrade ? 1 : 0]?.focus();
      },
    });
    const cell = make("th", {scope: "col"}, press);
    cell.setAttribute("aria-sort", isSorted ? "ascending" : "none");
    return cell;
  }

  private rowOf({person, did}: Row, exercise: HistoryExercise | undefined): HTMLElement {
    const {pass = null, trials = 1} = exercise ?? {};
    const name = make("button", {
      ...{type: "button", className: "name", textContent: person.name},
      onclick: () => this.open(person.person),
    });
    const who = make("th", {scope: "row"}, name);
    if (!person.here) who.append(" ", make("span.quiet", say("history.left")));
    const grade = make("td.grade");
    if (did) {
      const {mean} = did.grade;
      const isPoor = pass !== null && mean !== null && mean < pass;
      grade.append(make("b", {className: isPoor ? "poor" : ""}, gradeFigure(did.grade)));
      grade.title = gradeWords(did.grade, trials);
      if (isPoor) grade.append(" ", make("span.quiet", say("history.below")));
    }
    const lost = did?.lost[0];
    const row = make(
      "tr",
      who,
      grade,
      make("td.wide", did ? sayNumber(did.done, 0) : ""),
      make(
        "td.wide",
        lost
          ? say("history.costs", {
              criterion: criterionName(exercise, lost.criterion),
              points: Math.round(lost.points),
            })
          : "",
      ),
    );
    const light = (on: boolean): void => this.curve.light(on ? person.person : undefined);
    row.addEventListener("pointerenter", () => light(true));
    row.addEventListener("pointerleave", () => light(false));
    name.addEventListener("focus", () => light(true));
    name.addEventListener("blur", () => light(false));
    return row;
  }
}
