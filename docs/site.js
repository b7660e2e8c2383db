// What the theme leaves out for those who use a keyboard or a screen reader.
const mend = () => {
  // Boxes around wide tables scroll: the keyboard must reach them.
  for (const box of document.querySelectorAll(".md-typeset__scrollwrap:not([tabindex])")) box.tabIndex = 0;
  // Each part that is announced as navigation needs a name of its own.
  const seen = new Map();
  for (const nav of document.querySelectorAll("nav")) {
    const by = document.getElementById(nav.getAttribute("aria-labelledby"));
    const name = (nav.dataset.name ||= (by ? by.textContent : nav.getAttribute("aria-label") || "Code").trim());
    const times = (seen.get(name) || 0) + 1;
    seen.set(name, times);
    const label = times > 1 ? `${name} (${times})` : name;
    if (nav.getAttribute("aria-label") === label) continue;
    nav.removeAttribute("aria-labelledby");
    nav.setAttribute("aria-label", label);
  }
};
new MutationObserver(mend).observe(document.documentElement, {childList: true, subtree: true});
mend();
