const again = 60000
for (const page of Bokeh.documents) {
  const apply = page.apply_json_patch.bind(page)
  page.apply_json_patch = (...patch) => {
    // What the server sends is not new to it: Bokeh would send it back whole with the next event.
    const own = new Set(page._new_models)
    try {
      apply(...patch)
      page._new_models = own
    } catch (error) {
      const last = Number(sessionStorage.getItem("broken"))
      sessionStorage.setItem("broken", Date.now())
      if (Date.now() - last > again) location.reload()
      else show_lost(words)
      throw error
    }
  }
}
