// What the grip bears, as a curve around the object: its distance from the middle is the largest load in that direction.
function drawMargin(margin) {
  document.querySelectorAll(".bears").forEach(part => { part.hidden = !margin; });
  if (!margin) return;
  $("bears").textContent = fixed(margin.weakest_n, 2);
  $("across").textContent = fixed(margin.across_n, 2);
  $("slips").textContent = margin.slips === null ? "–" : `finger ${margin.slips}`;
  const most = Math.max(...margin.along_n, 1e-9);
  const corners = margin.along_n.map((load, at) => {
    const angle = 2 * Math.PI * at / margin.along_n.length, far = 100 * load / most;
    return `${(far * Math.cos(angle)).toFixed(1)},${(-far * Math.sin(angle)).toFixed(1)}`;
  });
  // A circle at a round number of newtons.
  const power = 10 ** Math.floor(Math.log10(most)), ring = [5, 2, 1].map(of => of * power).find(of => of <= most);
  const far = 100 * ring / most;
  $("margin").innerHTML = `<polygon points="${corners.join(" ")}"/><circle r="${far.toFixed(1)}"/><path d="M-100 0H100M0-100V100"/>`
    + `<text x="3" y="${(-far - 3).toFixed(1)}">${ring} N</text>`;
}
