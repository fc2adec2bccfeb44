"use strict";
(() => {
  const $ = (selector, root = document) => root.querySelector(selector);
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const page = document.documentElement;
  const claims = all(".claim");
  const read = (key, otherwise) => {
    try { return JSON.parse(localStorage.getItem(key)) ?? otherwise; } catch { return otherwise; }
  };
  const write = (key, value) => {
    try { localStorage.setItem(key, JSON.stringify(value)); } catch { /* storage may be closed to files */ }
  };

  $(".tools").hidden = false;

  // Theme: follow the reader's scheme, or one of the two.
  const themes = ["auto", "light", "dark"];
  const setTheme = (theme) => {
    page.dataset.theme = theme;
    $("#theme").textContent = `Theme: ${theme}`;
    write("bristle-theme", theme);
  };
  const nextTheme = () => setTheme(themes[(themes.indexOf(page.dataset.theme) + 1) % themes.length]);
  setTheme(themes.includes(read("bristle-theme", "auto")) ? read("bristle-theme", "auto") : "auto");
  $("#theme").addEventListener("click", nextTheme);

  // Search and filters; their state stands in the address as #?q=...&hide=...
  const search = $("#search");
  const boxes = all(".filters input");
  const texts = new Map();
  const parts = all(".claim, .deviation, .sum, .check, main > section > .card, main > section > .equation");
  for (const part of parts) texts.set(part, part.textContent.toLowerCase());
  const apply = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let found = 0;
    for (const part of parts) {
      const match = words.every((word) => texts.get(part).includes(word));
      part.hidden = !match;
      if (match) found += 1;
    }
    $("#found").textContent = words.length ? `${found} found` : "";
    const nothing = $(".nothing");
    if (nothing) nothing.hidden = claims.some((claim) => claim.checkVisibility());
  };
  const remember = () => {
    const state = new URLSearchParams();
    if (search.value) state.set("q", search.value);
    const hidden = boxes.filter((box) => !box.checked).map((box) => box.id.slice(5));
    if (hidden.length) state.set("hide", hidden.join(","));
    const text = state.toString();
    history.replaceState(null, "", text ? `#?${text}` : "#");
    apply();
  };
  search.addEventListener("input", remember);
  for (const box of boxes) box.addEventListener("change", remember);

  const arrive = () => {
    const hash = decodeURIComponent(location.hash.slice(1));
    if (hash.startsWith("?")) {
      const state = new URLSearchParams(hash.slice(1));
      search.value = state.get("q") ?? "";
      const hidden = (state.get("hide") ?? "").split(",");
      for (const box of boxes) box.checked = !hidden.includes(box.id.slice(5));
      apply();
      return;
    }
    const target = hash && document.getElementById(hash);
    if (!target) return;
    if (target.hidden || !target.checkVisibility()) clear();
    const details = target.matches(".claim") && $("details", target);
    if (details) details.open = true;
    target.scrollIntoView();
  };
  const clear = () => {
    search.value = "";
    for (const box of boxes) box.checked = true;
    apply();
  };
  addEventListener("hashchange", arrive);

  // Cost of each claim, from the facts of the run.
  const facts = JSON.parse($("#run-facts").textContent);
  for (const cost of all(".cost")) {
    const seconds = facts.seconds?.[cost.dataset.cost];
    if (typeof seconds === "number") cost.textContent = `takes ${seconds < 0.1 ? "less than 0.1" : seconds.toPrecision(2)} s to compute`;
  }

  // Commands can be copied.
  if (navigator.clipboard) {
    for (const command of all(".command")) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = "Copy";
      button.setAttribute("aria-label", `Copy ${command.textContent}`);
      button.addEventListener("click", () => {
        navigator.clipboard.writeText(command.textContent).then(() => { button.textContent = "Copied"; }, () => {});
      });
      command.after(" ", button);
    }
  }

  // Review: a judgement and a note for each claim and each question, kept in this browser, exported as JSON or Markdown.
  const identity = ($(".facts .hash")?.textContent ?? "").replace("sha256:", "");
  const key = `bristle-review-${identity}`;
  const notes = read(key, {});
  const questions = all(".check");
  const judgements = ["not checked", "I agree", "I disagree", "unclear"];
  const checked = (parts) => `${parts.filter((part) => notes[part.id]?.judgement > 0).length} of ${parts.length}`;
  const count = () => {
    const own = questions.length ? `, ${checked(questions)} questions` : "";
    $("#reviewed").textContent = `${checked(claims)} claims checked${own}`;
  };
  const form = (part) => {
    const note = notes[part.id] ?? (notes[part.id] = { judgement: 0, text: "" });
    const box = document.createElement("div");
    box.className = "review";
    const label = document.createElement("label");
    label.append("My judgement ");
    const select = document.createElement("select");
    judgements.forEach((word, index) => select.append(new Option(word, index, false, index === note.judgement)));
    label.append(select);
    const area = document.createElement("textarea");
    area.value = note.text;
    area.setAttribute("aria-label", `Note on ${part.id}`);
    const keep = () => {
      note.judgement = Number(select.value);
      note.text = area.value;
      write(key, notes);
      count();
    };
    select.addEventListener("change", keep);
    area.addEventListener("input", keep);
    box.append(label, area);
    part.append(box);
  };
  const review = () => {
    const on = $("#review").getAttribute("aria-pressed") !== "true";
    $("#review").setAttribute("aria-pressed", String(on));
    $("#review-bar").hidden = !on;
    if (on && !$(".review")) [...claims, ...questions].forEach(form);
    for (const box of all(".review")) box.hidden = !on;
    count();
  };
  $("#review").addEventListener("click", review);
  if (!claims.length) $("#review").hidden = true;
  const save = (name, type, text) => {
    const link = document.createElement("a");
    link.href = `data:${type};charset=utf-8,${encodeURIComponent(text)}`;
    link.download = name;
    link.click();
  };
  const own = (part) => ({
    judgement: judgements[notes[part.id]?.judgement ?? 0],
    note: notes[part.id]?.text ?? "",
  });
  const rows = () => claims.map((claim) => ({ claim: claim.id, verdict: claim.dataset.verdict, ...own(claim) }));
  const words = (part, selector) => ($(selector, part)?.textContent ?? "").replace(/\s+/g, " ").trim();
  const list = () => questions.map((part) => ({
    question: part.id,
    source: words(part, ".locator"),
    text: words(part, ".question"),
    answer: part.dataset.answer,
    evidence: words(part, ".shown"),
    see: all(".shown a[href^='#']", part).map((link) => link.getAttribute("href")),
    ...own(part),
  }));
  $("#export-json").addEventListener("click", () => save("review.json", "application/json",
    JSON.stringify({ schema: "bristle/review/1", results: identity, commit: facts.commit ?? null, claims: rows(), checklist: list() }, null, 2)));
  $("#export-md").addEventListener("click", () => {
    const lines = [`# Review of ${document.title}`, "", `Results \`sha256:${identity}\``, ""];
    const add = (row, name, words) => {
      lines.push(`- [${row.judgement === judgements[0] ? " " : "x"}] **${name}** ${words}: ${row.judgement}`);
      if (row.note) lines.push(...row.note.split("\n").map((line) => `  > ${line}`));
    };
    lines.push("## Claims", "");
    for (const row of rows()) add(row, row.claim, `(${row.verdict})`);
    if (questions.length) lines.push("", "## Checklist", "");
    for (const row of list()) {
      add(row, row.question, `${row.text} (${row.source}; the report says: ${row.answer})`);
      lines.push(`  ${row.evidence}`);
    }
    save("review.md", "text/markdown", `${lines.join("\n")}\n`);
  });

  // Keys.
  const help = () => {
    const open = $("#help").hidden;
    $("#help").hidden = !open;
    $("#keys").setAttribute("aria-expanded", String(open));
  };
  $("#keys").addEventListener("click", help);
  const current = () => claims.findIndex((claim) => `#${claim.id}` === location.hash);
  const go = (step) => {
    const shown = claims.filter((claim) => claim.checkVisibility());
    if (!shown.length) return;
    const at = shown.indexOf(claims[current()]);
    const next = at < 0 ? (step > 0 ? 0 : shown.length - 1) : Math.min(Math.max(at + step, 0), shown.length - 1);
    location.hash = shown[next].id;
  };
  addEventListener("keydown", (event) => {
    const typing = event.target.closest?.("input:not([type=checkbox], [type=radio]), textarea, select");
    if (event.key === "Escape") {
      clear();
      remember();
      event.target.blur?.();
      return;
    }
    if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
    const toggle = () => {
      const details = claims[current()] && $("details", claims[current()]);
      if (details) details.open = !details.open;
    };
    const action = {
      "/": () => search.focus(), j: () => go(1), k: () => go(-1), o: toggle,
      r: () => claims.length && review(), t: nextTheme, "?": help,
    }[event.key];
    if (action) {
      event.preventDefault();
      action();
    }
  });

  // Paper shows everything that is folded away, except tables of data.
  const opened = [];
  addEventListener("beforeprint", () => {
    for (const details of all("details:not(.data):not([open])")) {
      details.open = true;
      opened.push(details);
    }
  });
  addEventListener("afterprint", () => { for (const details of opened.splice(0)) details.open = false; });

  apply();
  arrive();
})();
