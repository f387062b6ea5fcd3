// Frame of a notebook with the live page in it: its messages go to the kernel, those of the kernel to the page.
function render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.setAttribute("sandbox", "allow-scripts");
  frame.allow = "clipboard-write";
  frame.title = "Live page";
  frame.style.cssText = "width: 100%; height: 820px; border: 0";
  const tell = (text) => text && frame.contentWindow && frame.contentWindow.postMessage(text, "*");
  const kept = ["findings", "run"].map((name) => [`change:${name}`, () => tell(model.get(name))]);
  const own = (said) => tell(said.text);
  const heard = (event) => {
    if (event.source !== frame.contentWindow) {
      return;
    }
    if (event.data.type === "open") {
      kept.forEach(([, action]) => action());
    }
    model.send(event.data);
  };
  window.addEventListener("message", heard);
  kept.forEach(([name, action]) => model.on(name, action));
  model.on("msg:custom", own);
  frame.srcdoc = model.get("page");
  el.append(frame);
  return () => {
    window.removeEventListener("message", heard);
    kept.forEach(([name, action]) => model.off(name, action));
    model.off("msg:custom", own);
  };
}

export default { render };
